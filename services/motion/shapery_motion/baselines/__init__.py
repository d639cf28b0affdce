"""The two methods that the dissertation compares its own with (section 5.3)."""
