"""What a Python program gets from `import uavftc`: flights, comparisons, designs and campaigns as values.

Nothing is computed here: each module gives a job, its result on disk, and its figures one face.
"""
