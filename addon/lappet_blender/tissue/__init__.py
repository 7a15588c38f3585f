"""The tissue of a scene: any mesh, its faces' groups, materials, bones, and what is wrong with it."""
