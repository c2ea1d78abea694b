# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene becomes results: scene file, case, run loop, checks, summary."""

from masonry_cd.foundation.own_packages import require_own_packages

require_own_packages()
