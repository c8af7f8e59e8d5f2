"""What joins boards, parts and the world: pins by nets, quantities by named signals, serial ends by lines.

`model` is what a bench file says, `plan` what it means once every name is found and every rule is kept, `world_signals`
what a world has to offer, `terminals` and `parts` bring it to life on a bench.
"""
