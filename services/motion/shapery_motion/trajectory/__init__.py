"""The profile ``trajectory``: clusters of vertices, the trajectories of each in a small basis, coded at one step."""
