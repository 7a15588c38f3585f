"""The procedure as a Blender scene keeps it: property groups, units, and the way to and from `lappet.Procedure`."""
