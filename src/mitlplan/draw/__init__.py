"""Pictures and animations of maps, plans and trajectories."""

from mitlplan.draw.animation import animation
from mitlplan.draw.picture import Picture, picture, rendered

__all__ = ["Picture", "animation", "picture", "rendered"]
