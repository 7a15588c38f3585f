"""Export and import of procedures and skin caches as USD, by menu and by drag and drop."""
