"""The one family of errors that users see: each names the value, what would be valid and the way out."""

from __future__ import annotations


class ArtrecError(Exception):
    """Base of every error that artrec_ros raises on purpose; its text is one line for the user."""


class ConfigError(ArtrecError):
    """A parameter, object or constraint file, or a value in it, is not valid."""


class ImageError(ArtrecError):
    """One image cannot be used; the next one may be fine."""


class SourceError(ArtrecError):
    """A bag or folder cannot be read."""
