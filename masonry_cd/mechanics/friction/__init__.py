"""The friction problem of one step: its data, Coulomb's law at one contact, its operators and error measures."""
