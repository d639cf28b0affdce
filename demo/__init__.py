"""The main job from end to end, on volumes that the project generates itself."""
