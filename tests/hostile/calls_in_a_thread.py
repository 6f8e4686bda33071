"""Hostile: lets a thread call, and goes on."""
import os
import threading
import urllib.request

import numpy as np
from rps.robotarium import Robotarium

PORT = int(os.environ["HOSTILE_PORT"])
thread = threading.Thread(target=urllib.request.urlopen, args=(f"http://127.0.0.1:{PORT}/",))  # <~ network
thread.start()
thread.join()

r = Robotarium(number_of_robots=1, initial_conditions=np.zeros((3, 1)))
for _ in range(3):
    r.get_poses()
    r.step()
r.debug()
