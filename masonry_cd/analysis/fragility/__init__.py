# SPDX-License-Identifier: GPL-3.0-or-later
"""What the runs of a study say together: intensity measures, limit states, fragilities and their bands."""
