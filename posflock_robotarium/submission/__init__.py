"""From a script to what is uploaded: bundled flat, and rehearsed with the testbed's own versions.

``interpreters`` finds a Python of the testbed's version; ``rehearsal_launcher`` runs in it.
"""

__all__ = ["bundle", "manifest", "rehearse", "upload_folder"]
