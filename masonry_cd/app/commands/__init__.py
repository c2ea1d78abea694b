# SPDX-License-Identifier: GPL-3.0-or-later
"""The commands, one module each, whose function of the same name returns a :class:`masonry_cd.app.result.Result`.

Those over many runs of one scene are in :mod:`masonry_cd.studies`.
"""
