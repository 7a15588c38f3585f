"""How a procedure looks: meshes of the skin, materials, sutures as thread, hooks as steel, marks on the skin."""
