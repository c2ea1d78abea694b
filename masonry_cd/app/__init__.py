"""A scene becomes results: scene file, case, run loop, checks, summary."""
