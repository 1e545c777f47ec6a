"""Hybrids of planar shear whose zone begins everywhere, held to grains alone (docs/validation/hybrid_prediction.md): `tests/figures.py everywhere FOLDER`.

FOLDER has the runs dem_N and hybrid_N of packings N, N/comparison.json of `scree report --between`, and of some packings again_N, grains alone once more with another speed of the plate, which tell
what one packing differs from itself by. `first` is the strain at which the first grains turn into points: all before is equal by construction. Stresses are moving averages over half a percent of
strain, intervals by Student's t over packings. The null model is grains alone of each other packing in the place of the hybrid."""

import glob
import json
import os
import re

import numpy
from scipy import stats

from figures import series

WINDOW = 0.005
# From here on bands are measured, and what share of the shear is inside the zone.
BANDS_FROM = 0.178
ENDS = (0.3, 0.57)
EARLY = (0.01, 0.1)
# m
CELL = 7.5e-3
MEASURES = ("mean since", "rms since", "mean from 1 to 10 %", "rms from 1 to 10 %", "volume strain")
# Of which one packing's difference from itself is asked for.
OF_ITSELF = (0, 2, 4)


def everywhere(folder):
    """To 30 % of strain of all packings, and to 57 of those that go so far."""
    numbers = lambda kind: {int(found.group(1)) for path in glob.glob(f"{folder}/{kind}_*/summary.json") if (found := re.search(rf"{kind}_(\d+)/", path))}
    packings = [Packing(folder, number, number in numbers("again")) for number in sorted(numbers("dem") & numbers("hybrid"))]
    for packing in packings:
        if packing.first is None:
            print(f"{packing.number}: no grain has turned into a point")
    packings = [packing for packing in packings if packing.first is not None]
    for end in ENDS:
        here = [packing for packing in packings if packing.end > end - WINDOW]
        if here:
            print(f"To {100 * end:.0f} % of strain, {len(here)} packings")
            held_to_grains_alone(here, end)


class Packing:
    """One packing as grains alone, as a hybrid and, if there is such a run, as grains alone once more."""

    def __init__(self, folder, number, again):
        self.number = number
        self.alone, self.hybrid = (columns(f"{folder}/{kind}_{number}") for kind in ("dem", "hybrid"))
        self.again = columns(f"{folder}/again_{number}") if again else None
        path = f"{folder}/{number}/comparison.json"
        runs = json.load(open(path))["bands"]["runs"] if os.path.exists(path) else []
        bands = {run["run"].split()[0]: (run["height_m"], run["thickness_d50"]) for run in runs}
        self.bands = [bands.get(f"{kind}_{number}", (None, None)) for kind in ("hybrid", "dem")]
        self.inside = judged(f"{folder}/hybrid_{number}/log.jsonl")
        have_points = numpy.flatnonzero(self.hybrid["points"] > 0)
        self.first_row = int(have_points[0]) if len(have_points) else None
        self.first = self.hybrid["strain"][self.first_row] if len(have_points) else None

    @property
    def end(self):
        """Strain to which both runs go."""
        return min(self.alone["strain"][-1], self.hybrid["strain"][-1])

    def bits(self):
        """Whether the series are equal until the first points."""
        rows = min(self.first_row, len(self.alone["strain"]))
        if (self.alone["step"][:rows] != self.hybrid["step"][:rows]).any():
            return "rows of other instants"
        same = all((self.alone[name][:rows] == self.hybrid[name][:rows]).all() for name in self.alone if name in self.hybrid)
        return f"{'the same' if same else 'OTHER'} bits in {rows} rows"

    def off(self, other, end):
        """Measures of another run off grains alone of this packing, %."""
        end = min(end, self.alone["strain"][-1], other["strain"][-1])
        at = numpy.arange(0.004, end - WINDOW / 2, 0.001)
        wanted, difference = smooth(self.alone, at), smooth(other, at) - smooth(self.alone, at)
        told = []
        for low, high in ((self.first, end), EARLY):
            inside = (at > low) & (at < high)
            over = 100 / wanted[inside].mean()
            told += [over * difference[inside].mean(), over * (difference[inside] ** 2).mean() ** 0.5]
        return [*told, 100 * (volume(other, end) - volume(self.alone, end))]


def judged(log):
    """Shares of the shear inside the zone between two judgements, of all from BANDS_FROM on."""
    events = [json.loads(line) for line in open(log)]
    return [event["shear_in_zones"] for event in events if event["event"] == "zone_judged" and event["strain"] >= BANDS_FROM]


def columns(run):
    rows = series(run)
    return {name: numpy.array([row[name] for row in rows]) for name in rows[0]}


def smooth(of, at):
    return numpy.array([of["shear_stress"][abs(of["strain"] - middle) < WINDOW / 2].mean() for middle in at])


def volume(of, end):
    return of["volume_strain"][abs(of["strain"] - end + 0.003) < WINDOW / 2].mean()


def peak(of, end):
    """Strain of the largest moving average, %, and that stress, kPa."""
    at = numpy.arange(0.004, end - WINDOW / 2, 0.001)
    stress = smooth(of, at)
    return 100 * at[stress.argmax()], stress.max() / 1e3


def interval(values):
    values = numpy.array(values)
    spread = values.std(ddof=1) if len(values) > 1 else float("nan")
    half = stats.t.ppf(0.975, len(values) - 1) * spread / len(values) ** 0.5 if len(values) > 1 else float("nan")
    return f"{values.mean():+.2f} +- {half:.2f} (each {spread:.2f})"


def rms(values):
    return float((numpy.array(values) ** 2).mean() ** 0.5)


def worse(null, ours):
    """That the null model is farther off than the hybrid: p of Wilcoxon's signed ranks over packings, one-sided."""
    null, ours = numpy.abs(null), numpy.abs(ours)
    return stats.wilcoxon(null, ours, alternative="greater").pvalue if len(ours) > 1 else float("nan")


def held_to_grains_alone(packings, end):
    hybrids = [packing.off(packing.hybrid, end) for packing in packings]
    # Mean absolute difference of all others in the place of each.
    others = lambda packing: [abs(numpy.array(packing.off(other.alone, end))) for other in packings if other is not packing]
    nulls = [numpy.mean(others(packing), axis=0) if len(packings) > 1 else numpy.full(len(MEASURES), float("nan")) for packing in packings]
    itself = [(packing.number, packing.off(packing.again, end)) for packing in packings if packing.again and packing.again["strain"][-1] > end - WINDOW]
    for packing, off in zip(packings, hybrids):
        equal = min(max((packing.first - EARLY[0]) / (EARLY[1] - EARLY[0]), 0), 1)
        inside = packing.hybrid["strain"] <= end
        grains = packing.hybrid["grains"][inside]
        told = ", ".join(f"{name} {value:+.2f} %" for name, value in zip(MEASURES, off))
        print(f"{packing.number}: {packing.bits()}, first points at {100 * packing.first:.2f} % of strain, {100 * equal:.0f} % of the span from 1 to 10 %, {grains[-1]:.0f} of {grains[0]:.0f} grains at the end: {told}{band(packing)}{inside_zone(packing)}")
    for number, off in itself:
        print(f"{number} once more: {', '.join(f'{name} {value:+.2f} %' for name, value in zip(MEASURES, off))}")
    told = []
    for column, name in enumerate(MEASURES):
        ours, null = [row[column] for row in hybrids], [row[column] for row in nulls]
        own = [off[column] for _, off in itself]
        of_itself = f"; single ones {rms(ours) / rms(own):.2f} times those of {len(own)} packings from themselves" if own and column in OF_ITSELF else ""
        told.append(worse(null, ours))
        print(f"{name}: {interval(ours)} %, {numpy.abs(ours).mean():.2f} off in the mean of absolute values{of_itself}; other packings {numpy.mean(null):.2f}, worse by p {told[-1]:.5f}")
    peaks(packings, end)
    # Bands are those between the strains of `scree report`, which go to the end of the longest runs.
    if end == ENDS[-1] and len(packings) > 1:
        six = [told[0], told[1], told[2], told[4], places(packings), thicknesses(packings)]
        print(f"other packings are farther off (p < 0.05) in {sum(p < 0.05 for p in six)} of 6")


def band(packing):
    (height, thickness), (wanted, wanted_thickness) = packing.bands
    if height is None or wanted is None:
        return ""
    told = f"; band at {1e3 * height:.0f} mm for {1e3 * wanted:.0f}"
    return told if thickness is None or wanted_thickness is None else f"{told}, {thickness:.1f} D50 for {wanted_thickness:.1f}"


def inside_zone(packing):
    shares = 100 * numpy.array(packing.inside)
    return f"; inside the zone {shares.mean():.1f} % of the shear by the mean of {len(shares)} judgements, {shares.min():.0f} at least" if len(shares) else ""


def peaks(packings, end):
    ours, wanted = (numpy.array([peak(getattr(packing, kind), end) for packing in packings]).T for kind in ("hybrid", "alone"))
    # Equal by construction where both moving averages end before the first points.
    late = sum(packing.first < max(strains) / 100 + WINDOW / 2 for packing, strains in zip(packings, zip(ours[0], wanted[0])))
    for name, difference in (("strain at the peak", ours[0] - wanted[0]), ("peak over that of grains alone", 100 * (ours[1] / wanted[1] - 1))):
        p = stats.ttest_1samp(difference, 0).pvalue if difference.any() and len(packings) > 1 else float("nan")
        print(f"{name}: {interval(difference)} %, p {p:.2f}; {late} of {len(packings)} peaks after the first points, {int((difference == 0).sum())} the same")


def instead(theirs):
    """Of grains alone of each other packing in the place of the hybrid: the mean difference from each packing."""
    apart = abs(theirs[:, None] - theirs[None, :])
    return apart[~numpy.eye(len(theirs), dtype=bool)].reshape(len(theirs), -1).mean(axis=1)


def both(packings, which):
    """A figure of the bands, hybrid and grains alone, of packings that have it in both."""
    found = [[band[which] for band in packing.bands] for packing in packings]
    without = [packing.number for packing, pair in zip(packings, found) if None in pair]
    if without:
        print(f"no such band of {without}")
    return numpy.array([pair for pair in found if None not in pair]).T


def places(packings):
    ours, theirs = both(packings, 0)
    apart = abs(ours[:, None] - theirs[None, :])
    own = numpy.diag(apart)
    null = instead(theirs)
    random = numpy.random.default_rng(1)
    row = numpy.arange(len(ours))
    near = numpy.array([(apart[row, random.permutation(row)] <= CELL).sum() for _ in range(100_000)])
    p = (1 + (near >= (own <= CELL).sum()).sum()) / (1 + len(near))
    print(f"place: {int((own <= CELL).sum())} of {len(ours)} within {1e3 * CELL:g} mm, {near.mean():.1f} by exchange, p {p:.5f}; {1e3 * own.mean():.1f} mm apart, {1e3 * own.max():.1f} at most, {1e3 * null.mean():.1f} with other packings in their place, worse by p {worse(null, own):.5f}")
    return worse(null, own)


def thicknesses(packings):
    ours, theirs = both(packings, 1)
    ratio = ours.var(ddof=1) / theirs.var(ddof=1)
    below = stats.f.cdf(ratio, len(ours) - 1, len(ours) - 1)
    null = instead(theirs)
    print(f"thickness: {interval(ours - theirs)} D50; over packings {ours.std(ddof=1):.1f} D50 for {theirs.std(ddof=1):.1f}, F test p {2 * min(below, 1 - below):.3f}; {abs(ours - theirs).mean():.1f} apart, {null.mean():.1f} with other packings in their place, worse by p {worse(null, ours - theirs):.4f}")
    return worse(null, ours - theirs)
