r"""Certificates for robots that answer late, and not quite as they are told.

A command acts after a dead time τ, approached with a first-order lag T, times a gain g. Certified
for where robots are seen, it arrives where they no longer are. But there is a point that answers at
once: where a robot would come to rest if it were told to stop now, its *stop point* s. What is in
flight moves robots towards it and leaves it where it is; a new command moves it by g times itself,
with no delay at all. So

1. the stop points are predicted from the poses seen and the commands in flight
   (`stop_prediction`);
2. they are certified, like projection points of robots that obey at once (`late_certificate`), and
   where they are too close by what is seen, by rows that hold whatever the errors are within their
   bounds (`cautious_rows`); who is told to stop leaves its stop point where it is, so that there
   always is a safe command;
3. true positions are weighted means of past stop points, so what is kept between these is kept
   between robots, less what a mean of points outside a circle can lie inside of it.

Everything that is not known exactly (gains, delays, tracking, noise) is a range in `late_robots`,
and becomes a distance by a formula in `late_margins`. Formulas and their proof stand in
``docs/explanations/late-robots.md``.

References
----------
Artstein, Linear systems with delayed controls: a reduction, IEEE Transactions on Automatic Control
27 (1982): the state that delayed inputs reduce to. Breeden, Garg and Panagou, Control barrier
functions in sampled-data systems, IEEE Control Systems Letters 6 (2022): margins for what happens
between samples.
"""

__all__ = ["late_certificate", "late_margins", "late_robots"]
