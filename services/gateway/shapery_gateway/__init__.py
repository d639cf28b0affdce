"""The HTTP gateway of Shapery."""
