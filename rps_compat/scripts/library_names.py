"""Names of scipy and matplotlib that the testbed's versions have no more, not yet, or not for long.

The lists are compared with the libraries, from scipy 1.1 to 1.18 and matplotlib 2.2 to 3.11, by
``tools/library_names.py``. Values are as in :mod:`~rps_compat.scripts.numpy_names`: what to write,
with a leading dot for a name of the same module and ``{}`` for that module; a phrase, where no name
can take its place; "" where there is nothing like it.
"""

from __future__ import annotations

_WINDOWS = "{}.windows."
_CMAP = "write matplotlib.colormaps"

#: Gone: module → names → what to write or do.
GONE = {
    "scipy": {
        "rand": "write numpy.random.rand(…)", "randn": "write numpy.random.randn(…)",
        "ifft": "write scipy.fft.ifft(…)", "logn": "write numpy.emath.logn(…)",
    },
    "scipy.integrate": {
        "cumtrapz": ".cumulative_trapezoid", "simps": ".simpson", "trapz": ".trapezoid",
        "quadrature": "write quad(…)", "romberg": "write quad(…)", "quad_explain": "",
        "AccuracyWarning": "",
    },
    "scipy.interpolate": {
        "spline": "write make_interp_spline(…)", "spleval": "write BSpline", "splmake":
        "write make_interp_spline(…)", "spltopp": "write PPoly.from_spline(…)", "dfitpack": "",
    },
    "scipy.io": {"byteordercodes": ""},
    "scipy.linalg": {
        "pinv2": ".pinv", "tri": "write numpy.tri(…)", "tril": "write numpy.tril(…)",
        "triu": "write numpy.triu(…)", "flinalg": "", "linalg_version": "",
    },
    "scipy.misc": {
        "comb": "write scipy.special.comb(…)", "factorial": "write scipy.special.factorial(…)",
        "factorial2": "write scipy.special.factorial2(…)", "factorialk":
        "write scipy.special.factorialk(…)", "logsumexp": "write scipy.special.logsumexp(…)",
        "pade": "write scipy.interpolate.pade(…)", "derivative":
        "write scipy.differentiate.derivative(…)", "central_diff_weights": "",
        "ascent": "write scipy.datasets.ascent()", "face": "write scipy.datasets.face()",
        "electrocardiogram": "write scipy.datasets.electrocardiogram()", "doccer": "", "info": "",
        "source": "write inspect.getsource(…)", "who": "write dir()",
        # These came with pillow.
        "imread": "write matplotlib.pyplot.imread(…)",
        "imsave": "write matplotlib.pyplot.imsave(…)",
        "imshow": "write matplotlib.pyplot.imshow(…)", "imresize": "write PIL.Image.resize(…)",
        "imrotate": "write scipy.ndimage.rotate(…)", "imfilter": "write PIL.ImageFilter",
        "bytescale": "", "fromimage": "write numpy.asarray(…)", "toimage":
        "write PIL.Image.fromarray(…)",
    },
    "scipy.ndimage": {"imread": "write matplotlib.pyplot.imread(…)", "io": ""},
    "scipy.odr": {"add_newdocs": ""},
    "scipy.signal": {
        **{
            name: _WINDOWS + name
            for name in [
                "barthann", "bartlett", "blackman", "blackmanharris", "bohman", "boxcar",
                "chebwin", "cosine", "exponential", "flattop", "gaussian", "general_gaussian",
                "hamming", "hann", "kaiser", "nuttall", "parzen", "triang", "tukey",
            ]
        },
        "hanning": "{}.windows.hann", "slepian": "write scipy.signal.windows.dpss(…)",
        "bspline": "write scipy.interpolate.BSpline", "quadratic": "", "cubic": "",
        "cascade": "", "daub": "", "qmf": "", "cwt": "", "morlet": "", "morlet2": "", "ricker": "",
        "impulse2": ".impulse", "lsim2": ".lsim", "step2": ".step", "cmplx_sort":
        "write numpy.sort_complex(…)", "sigtools": "",
    },
    "scipy.signal.windows": {"hanning": ".hann", "slepian": "write dpss(…)"},
    "scipy.sparse.linalg": {"arpack": "", "iterative": "", "linsolve": "", "utils": ""},
    "scipy.spatial.distance": {
        "kulsinski": "", "matching": ".hamming", "wminkowski": "write minkowski(…, w=…)",
        "CDistWeightedMetricWrapper": "", "PDistWeightedMetricWrapper": "",
    },
    "scipy.special": {
        "btdtr": ".betainc", "btdtri": ".betaincinv", "bessel_diff_formula": "", "errprint":
        "write errstate(…)", "hyp1f2": "", "hyp2f0": "", "hyp3f0": "", "np": "import numpy as np",
    },
    "scipy.stats": {
        "binom_test": "write binomtest(…).pvalue", "gilbrat": ".gibrat", "frechet_r":
        ".weibull_min", "frechet_l": ".weibull_max", "itemfreq":
        "write numpy.unique(…, return_counts=True)", "median_absolute_deviation":
        "write median_abs_deviation(…)", "rvs_ratio_uniforms": "write sampling.RatioUniforms",
        "NumericalInverseHermite": "{}.sampling.NumericalInverseHermite", "statlib": "",
        "PearsonRConstantInputWarning": ".ConstantInputWarning",
        "SpearmanRConstantInputWarning": ".ConstantInputWarning",
        "F_onewayConstantInputWarning": ".ConstantInputWarning",
        "PearsonRNearConstantInputWarning": ".NearConstantInputWarning",
        "F_onewayBadInputSizesWarning": ".DegenerateDataWarning",
    },
    "matplotlib": {
        "mplDeprecation": ".MatplotlibDeprecationWarning", "verbose": "write logging",
        "Verbose": "write logging", "URL_REGEX": "", "checkdep_dvipng": "",
        "checkdep_ghostscript": "", "checkdep_inkscape": "", "checkdep_pdftops": "",
        "checkdep_ps_distiller": "", "checkdep_tex": "", "checkdep_usetex": "",
        "checkdep_xmllint": "", "compare_versions": "", "dedent": "write inspect.cleandoc(…)",
        "get_home": "write pathlib.Path.home()", "get_label": "", "get_py2exe_datafiles": "",
        "is_url": "", "test": "", "tk_window_focus": "",
    },
    "matplotlib.animation": {"AVConvBase": "", "AVConvFileWriter": "", "AVConvWriter": ""},
    "matplotlib.axes": {"SecondaryAxis": "", "STEP_LOOKUP_MAP": ""},
    "matplotlib.cm": {
        "cmap_d": _CMAP, "register_cmap": f"{_CMAP}.register(…)",
        "unregister_cmap": f"{_CMAP}.unregister(…)", "revcmap": "write Colormap.reversed()",
        "LUTSIZE": "write matplotlib.rcParams['image.lut']",
    },
    "matplotlib.collections": {
        "BrokenBarHCollection": "write PolyCollection", "CIRCLE_AREA_FACTOR": "",
    },
    "matplotlib.colorbar": {"ColorbarPatch": ".Colorbar", "colorbar_factory": ""},
    "matplotlib.colors": {"DivergingNorm": ".TwoSlopeNorm", "makeMappingArray": ""},
    "matplotlib.dates": {
        "bytespdate2num": "", "date_ticker_factory": "write AutoDateLocator", "epoch2num": "",
        "hours": "", "IndexDateFormatter": "", "julian2num": "", "minutes": "", "mx2num": "",
        "num2epoch": "", "num2julian": "", "seconds": "", "strpdate2num": "", "weeks": "",
    },
    "matplotlib.figure": {"AxesStack": ""},
    "matplotlib.mlab": {
        "PCA": "write numpy.linalg.svd(…)", "find": "write numpy.nonzero(numpy.ravel(…))[0]",
        "frange": "write numpy.arange(…)", "griddata": "write scipy.interpolate.griddata(…)",
        "normpdf": "write scipy.stats.norm.pdf(…)", "prctile": "write numpy.percentile(…)",
        "bivariate_normal": "write scipy.stats.multivariate_normal.pdf(…)", "csv2rec":
        "write numpy.genfromtxt(…, names=True)", "log2": "write numpy.log2(…)", "dist":
        "write numpy.hypot(…)", "identity": "write numpy.identity(…)", "logspace":
        "write numpy.logspace(…)", "rk4": "write scipy.integrate.solve_ivp(…)",
        **dict.fromkeys(
            [
                "FormatBool", "FormatDate", "FormatDatetime", "FormatFloat", "FormatFormatStr",
                "FormatInt", "FormatMillions", "FormatObj", "FormatPercent", "FormatString",
                "FormatThousands", "amap", "apply_window", "base_repr", "binary_repr",
                "center_matrix", "cohere_pairs", "contiguous_regions", "cross_from_above",
                "cross_from_below", "csvformat_factory", "demean", "dist_point_to_segment",
                "distances_along_curve", "donothing_callback", "entropy", "exp_safe", "fftsurr",
                "get_formatd", "get_sparse_matrix", "get_xyz_where", "inside_poly",
                "is_closed_polygon", "ispower2", "isvector", "l1norm", "l2norm",
                "less_simple_linear_interpolation", "longest_contiguous_ones", "longest_ones",
                "movavg", "norm_flat", "offset_line", "path_length", "poly_below", "poly_between",
                "prctile_rank", "quad2cubic", "rec2csv", "rec2txt", "rec_append_fields",
                "rec_drop_fields", "rec_groupby", "rec_join", "rec_keep_fields", "rec_summarize",
                "recs_join", "rms_flat", "safe_isinf", "safe_isnan", "segments_intersect",
                "slopes", "stineman_interp", "stride_repeat", "stride_windows", "vector_lengths",
            ],
            "",
        ),
    },
    "matplotlib.patches": {"YAArrow": ".FancyArrowPatch"},
    "matplotlib.path": {"get_paths_extents": ""},
    "matplotlib.pyplot": {
        "hold": "leave it out: axes keep what is drawn", "ishold": "leave it out",
        "over": "leave it out", "spectral": ".nipy_spectral", "plotfile":
        "write plot(*numpy.loadtxt(…).T)", "colors": "", "plotting": "",
        "register_cmap": f"{_CMAP}.register(…)",
    },
    "matplotlib.scale": {
        "InvertedLog10Transform": ".InvertedLogTransform", "InvertedLog2Transform":
        ".InvertedLogTransform", "InvertedLogTransformBase": ".InvertedLogTransform",
        "InvertedNaturalLogTransform": ".InvertedLogTransform", "Log10Transform": ".LogTransform",
        "Log2Transform": ".LogTransform", "LogTransformBase": ".LogTransform",
        "NaturalLogTransform": ".LogTransform", "get_scale_docs": "",
    },
    "matplotlib.text": {"TextWithDash": "write annotate(…)", "get_rotation": ""},
    "matplotlib.ticker": {
        "Base": "", "IndexFormatter": "write FuncFormatter", "OldAutoLocator": ".AutoLocator",
        "OldScalarFormatter": ".ScalarFormatter", "closeto": "", "decade_down": "",
        "decade_up": "", "is_close_to_int": "", "is_decade": "", "nearest_long": "",
    },
    "mpl_toolkits.axes_grid1": {"LocatableAxes": "write Axes"},
}  # fmt: skip
#: Modules that are gone → what to import instead.
GONE_MODULES = {
    "matplotlib.afm": "",
    "matplotlib.blocking_input": "",
    "matplotlib.docstring": "",
    "matplotlib.fontconfig_pattern": "",
    "matplotlib.tight_bbox": "",
    "matplotlib.tight_layout": "",
    "matplotlib.type1font": "",
    "mpl_toolkits.axes_grid": "import mpl_toolkits.axes_grid1",
    "scipy.stats.sampling": "",
}
#: Names that `scipy` itself has; everything else that it handed on is to be taken from numpy.
SCIPY_KEPT = frozenset(
    {
        "LowLevelCallable", "cluster", "constants", "datasets", "differentiate", "fft", "fftpack",
        "integrate", "interpolate", "io", "linalg", "misc", "ndimage", "odr", "optimize",
        "show_config", "signal", "sparse", "spatial", "special", "stats", "test", "version",
    }
)  # fmt: skip

#: The testbed has it, and a newer version has not: module → name → what both have, or "".
LATER = {
    "scipy": {"odr": ""},
    "scipy.linalg": {"kron": "write numpy.kron(…)"},
    "scipy.spatial.distance": {"kulczynski1": "", "sokalmichener": ""},
    "scipy.special": {
        "clpmn": "", "lpmn": "", "lpn": "", "sph_harm": "write sph_harm_y(…)",
    },
    "scipy.stats": {"find_repeats": "write numpy.unique(…, return_counts=True)"},
    "matplotlib.cm": {"get_cmap": "write matplotlib.pyplot.get_cmap(…)"},
    "matplotlib.pyplot": {"plot_date": "write plot(…)"},
    "matplotlib.transforms": {"BboxTransformToMaxOnly": ""},
}  # fmt: skip
#: Newer than the testbed's: module → name → since which version.
NEWER = {
    "scipy.ndimage": {"vectorized_filter": "1.16"},
    "scipy.signal": {
        "closest_STFT_dual_window": "1.16", "firwin_2d": "1.16", "whittaker_henderson": "1.18",
    },
    "scipy.sparse": {
        "expand_dims": "1.17", "permute_dims": "1.17", "swapaxes": "1.17",
        "matrix_transpose": "1.18",
    },
    "scipy.sparse.linalg": {"funm_multiply_krylov": "1.17"},
    "scipy.spatial.transform": {"RigidTransform": "1.16"},
    "scipy.stats": {
        "Binomial": "1.16", "quantile": "1.16", "Logistic": "1.17", "matrix_t": "1.17",
        "spearmanrho": "1.17", "estimated_cdf": "1.18",
    },
    "matplotlib.colors": {"MultiNorm": "3.11", "Norm": "3.11"},
    "matplotlib.container": {"PieContainer": "3.11"},
    "matplotlib.pyplot": {"grouped_bar": "3.11", "pie_label": "3.11"},
}  # fmt: skip
