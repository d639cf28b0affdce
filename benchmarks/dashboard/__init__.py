"""What the dashboard costs whoever looks at it: `python -m benchmarks.dashboard`."""
