"""The paper's own simulation: point agents in free space, without arena, wheels or certificates.

``simulation`` runs batches of flocks under the paper's three models, ``sensing`` spoils what agents
see of each other, ``neighbour_search`` finds who is near.
"""

__all__ = ["inputs", "neighbour_search", "sensing", "simulation"]
