"""How the shipped vocabulary is made, from generated shapes alone. Needs scikit-image, which set-up brings along."""
