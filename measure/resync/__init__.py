"""What stray bytes cost the vehicle-interface board, as shipped and hardened."""
