"""What `artrec train` is made of: measurements in annotated images, joints, reports."""
