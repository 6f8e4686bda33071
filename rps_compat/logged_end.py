"""How a run ended, as its log tells."""

from barrier_certificates.word_enum import WordEnum


class LoggedEnd(WordEnum):
    """How a log calls the end of its run."""

    FINISHED = "finished"
    INTERRUPTED = "interrupted"
    FAILED = "failed"
