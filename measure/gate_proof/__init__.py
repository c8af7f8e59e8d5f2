"""How well the gate protects: small defects put into the product, and which of them its tests find."""
