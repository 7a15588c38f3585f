"""Start without a blank page: the application template, the asset library, and presets of one's own."""
