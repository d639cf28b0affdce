"""Where to start: octree cells with two classes of voxels, ranked by what speaks for a tumor (3.5.1–3.5.2)."""
