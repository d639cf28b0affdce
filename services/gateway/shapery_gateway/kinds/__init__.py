"""What the server can do: its job kinds, version and limits."""
