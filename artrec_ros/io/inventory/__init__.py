"""What any file or folder holds."""
