"""artrec_ros: articulated objects found by their coloured markers, with poses one can trust."""

__version__ = "0.1.0"
