"""Is there a steady state at the reference with what faults, damage and limits leave of an aircraft?"""
