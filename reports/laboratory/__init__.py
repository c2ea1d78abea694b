# SPDX-License-Identifier: GPL-3.0-or-later
"""What a laboratory hands over of a test: curves of force against displacement, and the histories of its gauges, as tables and plots."""
