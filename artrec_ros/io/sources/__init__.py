"""What is replayed: frames of bags and folders, one after the other."""
