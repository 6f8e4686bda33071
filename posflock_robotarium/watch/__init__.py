"""A running simulation in the browser: seen, held, stepped, and changed while it runs.

==========  ==========================================================================
requests    what the page may ask, read and checked in one place
pace        when the next step may begin: real time, faster, slower, held
settings    how a run is set: speed, profile, law
tuning      what may be changed of a flock while it flies, and within which range
picture     what the page is shown of one step
onlooker    looks on in the script's process: holds it, obeys requests, sends pictures
child       the script's process
script      that process as its starter sees it: folder, containment, what it says
show        what all pages see, and what becomes of what one of them asks
guard       who may talk to the server: this machine, with the address that was printed
server      the pages and their websocket
serving     the server from its start to Ctrl-C
==========  ==========================================================================

The script runs in a process of its own, under the project's own driver, in the containment of
`posflock verify`. The server runs in the command's process and never waits for the script.
"""
