"""Are the roads of OpenDRIVE files what Scenic makes of them?"""
