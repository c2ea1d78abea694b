"""A scene becomes results: scene file, case, run loop, checks, summary."""

from masonry_cd.rooms import require_own_rooms

require_own_rooms()
