"""The interface in other languages, by Blender's own mechanism."""
