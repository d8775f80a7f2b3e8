"""The longest period, and the slowest drive, that the worst path proves for a loop: by bisection of proofs."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

from stt_codegen.sampling.path.path_proof import prove_path
from stt_codegen.sampling.path.path_windows import PathLoop

SEARCH_STEPS = 12  # of bisection, after the value is known up to a factor of 2
DOUBLING_LIMIT = 12


def longest_path_period(loop: PathLoop, first_guess: Fraction) -> Fraction | None:
    """Return the longest sampling period in seconds that the path proves for the loop's drives; None where none is found.

    first_guess: a period from which the search starts. A shorter period is easier for the path, so the search is a bisection.
    """
    return largest_proved(lambda period: prove_path(loop.with_period(period)) is not None, first_guess)


def largest_proved(is_proved: Callable[[Fraction], bool], first_guess: Fraction) -> Fraction | None:
    """Return the largest value that is proved, to 2^-12 of itself; None where none is found below the guess."""
    low, high = first_guess, first_guess
    if is_proved(first_guess):
        for _ in range(DOUBLING_LIMIT):
            high = 2 * low
            if not is_proved(high):
                break
            low = high
        else:
            return low
    else:
        for _ in range(DOUBLING_LIMIT):
            low = high / 2
            if is_proved(low):
                break
            high = low
        else:
            return None
    for _ in range(SEARCH_STEPS):
        middle = (low + high) / 2
        low, high = (middle, high) if is_proved(middle) else (low, middle)
    return low
