"""The timeline of a scene: operators that add and edit events, and the panel that lists them."""
