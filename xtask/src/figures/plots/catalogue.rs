//! The charts of the pages: which figures they show, and where.

/// Figures of one part as a chart, and as a table of rows and series.
pub(super) struct Chart {
    /// Path without its ending; a name alone is only a table.
    pub(super) file: &'static str,
    pub(super) title: &'static str,
    pub(super) part: &'static str,
    /// Quantity and unit of the axis.
    pub(super) quantity: &'static str,
    pub(super) is_logarithmic: bool,
    /// A value with a dashed line, and its name.
    pub(super) reference: Option<(f64, &'static str)>,
    /// What the page calls the rows, and how the figures name them: `label | key`, or both alike.
    pub(super) rows: &'static [&'static str],
    pub(super) cells: Cells,
}

/// Which figure a cell shows.
#[derive(Clone, Copy)]
pub(super) enum Cells {
    /// The figure whose name is the pattern with the keys of row and series.
    Grid(&'static str, &'static [&'static str]),
    /// The figure of the row, and that of the program that it is compared with.
    Peers(&'static str),
    /// The figure of the row with its 95 % interval.
    Intervals,
    /// The same relative to the published value, in percent.
    OffPublished,
}

const METHODS: &[&str] = &[
    "paper's least squares",
    "linear stage",
    "prediction error",
    "with laws found | pred. error, laws = auto",
];

const CONDITIONS: &[&str] = &[
    "clean, 16384 counts",
    "clean, 4096 counts",
    "motor disturbed, 16384 counts | motor, 16384 counts",
    "link disturbed, 16384 counts | link, 16384 counts",
    "MuJoCo",
    "other laws",
];

const ESTIMATORS: &[&str] = &[
    "least squares | least-squares",
    "prediction error | prediction-error",
];

pub(super) const CHARTS: &[Chart] = &[
    Chart {
        file: "docs/reference/figures/twins-error",
        title: "Error of the parameters of simulated robots",
        part: "twins",
        quantity: "median error of all parameters, %; lines: from the best to the worst log",
        is_logarithmic: true,
        reference: None,
        rows: CONDITIONS,
        cells: Cells::Grid("{row}, {series}, error", METHODS),
    },
    Chart {
        file: "docs/reference/figures/twins-bound",
        title: "Distance from the best possible error",
        part: "twins",
        quantity: "error over its Cramér-Rao bound",
        is_logarithmic: true,
        reference: Some((1.0, "the bound")),
        rows: CONDITIONS,
        cells: Cells::Grid("{row}, {series}, bound", METHODS),
    },
    Chart {
        file: "docs/reference/figures/twins-coverage",
        title: "How often an interval contains the truth",
        part: "twins",
        quantity: "95 % intervals that contain the true value, %",
        is_logarithmic: false,
        reference: Some((95.0, "95 %")),
        rows: CONDITIONS,
        cells: Cells::Grid("{row}, {series}, inside", METHODS),
    },
    Chart {
        file: "docs/reference/figures/beside",
        title: "Other tools on the log of the demo",
        part: "beside",
        quantity: "median error of the parameters that the tool gives, %",
        is_logarithmic: true,
        reference: None,
        rows: &[
            "sprung, refinement",
            "sprung, least squares",
            "NumPy script of 66 lines | NumPy script",
            "MuJoCo sysid",
            "FIGAROH, which has no springs | FIGAROH, rigid joints",
        ],
        cells: Cells::Grid("{row}", &[""]),
    },
    Chart {
        file: "docs/reference/figures/verdicts-wrong",
        title: "Good verdicts that held-out data refute",
        part: "verdicts",
        quantity: "share of the good verdicts, %; best is 0",
        is_logarithmic: false,
        reference: None,
        rows: CASES,
        cells: Cells::Grid("{row}, {series}, wrong", ESTIMATORS),
    },
    Chart {
        file: "docs/reference/figures/verdicts-missed",
        title: "Good results without a good verdict",
        part: "verdicts",
        quantity: "share of the truly good results, %; best is 0",
        is_logarithmic: false,
        reference: None,
        rows: CASES,
        cells: Cells::Grid("{row}, {series}, missed", ESTIMATORS),
    },
    Chart {
        file: "docs/reference/figures/machines",
        title: "Real machines: promised error of the motor torque",
        part: "machines",
        quantity: "largest error of a joint over its torque, %",
        is_logarithmic: true,
        reference: None,
        rows: &[
            "EMPS | emps",
            "NEURA LARA 8, joint 2 | neura-lara8",
            "Stäubli TX40 | staubli-tx40",
            "Franka Panda | franka-panda",
            "Quanser flexible link | quanser-2dsfl",
        ],
        cells: Cells::Grid("{row}/{series}/torque", ESTIMATORS),
    },
    Chart {
        file: "docs/reference/figures/published",
        title: "Parameters of real machines beside published ones",
        part: "examples",
        quantity: "distance from the published value, %, with 95 % intervals",
        is_logarithmic: false,
        reference: Some((0.0, "published")),
        rows: &[
            "EMPS, mass | emps/declared/link1.m + carriage.rotor_inertia",
            "EMPS, viscous friction | emps/declared/carriage.motor_viscous",
            "EMPS, Coulomb friction | emps/declared/carriage.motor_coulomb",
            "TX40, viscous friction 1 | staubli-tx40/declared/joint_1.motor_viscous",
            "TX40, viscous friction 2 | staubli-tx40/declared/joint_2.motor_viscous",
            "TX40, Coulomb friction 1 | staubli-tx40/declared/joint_1.motor_coulomb",
            "TX40, Coulomb friction 2 | staubli-tx40/declared/joint_2.motor_coulomb",
            "TX40, rotor inertia 3 | staubli-tx40/declared/joint_3.rotor_inertia",
            "TX40, rotor inertia 4 | staubli-tx40/declared/joint_4.rotor_inertia",
            "TX40, rotor inertia 5 | staubli-tx40/declared/joint_5.rotor_inertia",
            "TX40, rotor inertia 6 | staubli-tx40/declared/joint_6.rotor_inertia",
        ],
        cells: Cells::OffPublished,
    },
    Chart {
        file: "docs/reference/figures/speed",
        title: "Processor time of the same work",
        part: "speed",
        quantity: "processor time, s",
        is_logarithmic: true,
        reference: None,
        rows: &[
            "simulate 10 s, 2 joints; Numba | simulated",
            "simulate 10 s, 7 joints; MuJoCo | seven simulated",
            "regressor, 7 joints; Pinocchio | regressor",
            "identify 10 s, 2 joints; NumPy | 10 s",
            "identify 1000 s, 2 joints; NumPy | 1000 s",
            "identify 15 s, 7 joints; Pinocchio | seven",
            "identify 1 h, 7 joints; extrapolated | hour",
        ],
        cells: Cells::Peers("other program"),
    },
    Chart {
        file: "docs/reference/figures/memory",
        title: "Memory of the same work",
        part: "speed",
        quantity: "largest memory of the process, MiB",
        is_logarithmic: true,
        reference: None,
        rows: &[
            "identify 10 s, 2 joints; NumPy | 10 s, memory",
            "identify 1000 s, 2 joints; NumPy | 1000 s, memory",
            "identify 15 s, 7 joints; Pinocchio | seven, memory",
            "identify 1 h, 7 joints; extrapolated | hour, memory",
        ],
        cells: Cells::Peers("other program"),
    },
    Chart {
        file: "diagnoses",
        title: "First diagnoses of damaged logs",
        part: "diagnoses",
        quantity: "logs",
        is_logarithmic: false,
        reference: None,
        rows: &[
            "delay link | delay-link",
            "delay motor | delay-motor",
            "delay torque | delay-torque",
            "delay all torques | delay-all-torques",
            "delay all links | delay-all-links",
            "delay two | delay-two",
            "delay three | delay-three",
            "offset link | offset-link",
            "offset torque | offset-torque",
            "gain link | gain-link",
            "gain motor | gain-motor",
            "gain torque | gain-torque",
            "lost link | lost-link",
            "lost motor | lost-motor",
            "drift link | drift-link",
            "drift motor | drift-motor",
            "drift torque | drift-torque",
            "saturated",
            "eccentric link | eccentric-link",
            "eccentric motor | eccentric-motor",
            "sign link | sign-link",
            "sign motor | sign-motor",
            "sign torque | sign-torque",
            "sign joint | sign-joint",
            "exchanged torques | exchanged-torques",
            "exchanged links | exchanged-links",
            "exchanged motors | exchanged-motors",
            "exchanged joints | exchanged-joints",
            "link for motor | link-for-motor",
            "unit torque | unit-torque",
            "degrees link | degrees-link",
            "degrees all | degrees-all",
            "gear motor | gear-motor",
            "gear torques | gear-torques",
            "stuck link | stuck-link",
            "hum",
            "spike link | spike-link",
            "noise link | noise-link",
            "none",
        ],
        cells: Cells::Grid(
            "{row}{series}",
            &[
                "right, of 3 | ",
                "made worse | , worse",
                "falsely good | , falsely good",
            ],
        ),
    },
    Chart {
        file: "docs/gallery/lara8-stiffness",
        title: "NEURA LARA 8: stiffness of joint 2 by setting",
        part: "examples",
        quantity: "stiffness, N·m/rad, with 95 % intervals",
        is_logarithmic: false,
        reference: None,
        rows: &[
            "motor row alone | neura-lara8/declared/motor row/joint2.stiffness",
            "prediction error | neura-lara8/refined/joint2.stiffness",
            "cut-off 3 Hz | neura-lara8/varied cut-off 3/joint2.stiffness",
            "cut-off 4 Hz | neura-lara8/declared/joint2.stiffness",
            "cut-off 10 Hz | neura-lara8/varied cut-off 10/joint2.stiffness",
        ],
        cells: Cells::Intervals,
    },
    Chart {
        file: "docs/gallery/quanser-stiffness",
        title: "Quanser: stiffness of stage 1 by setting",
        part: "examples",
        quantity: "stiffness, N·m/rad, with 95 % intervals",
        is_logarithmic: false,
        reference: Some((39.96, "the maker's value")),
        rows: &[
            "delay ignored, no constraints | quanser-2dsfl/ignored/stage1.stiffness",
            "delay estimated | quanser-2dsfl/estimated/stage1.stiffness",
            "delay given | quanser-2dsfl/declared/stage1.stiffness",
            "motor row alone | quanser-2dsfl/declared/motor row/stage1.stiffness",
            "prediction error | quanser-2dsfl/refined/stage1.stiffness",
        ],
        cells: Cells::Intervals,
    },
    Chart {
        file: "docs/gallery/servo",
        title: "A simulated servo: error of each parameter",
        part: "servo",
        quantity: "error, %",
        is_logarithmic: true,
        reference: None,
        rows: &[
            "torque per volt | BAM torque_per_volt",
            "back-EMF | BAM back_emf",
            "armature | BAM armature",
            "viscous friction | BAM viscous",
            "Coulomb friction | BAM coulomb",
            "friction by the motor's load | BAM load_motor",
            "friction by the external load | BAM load_external",
            "Stribeck friction | BAM stribeck",
        ],
        cells: Cells::Peers("BAM, 400 trials"),
    },
];

const CASES: &[&str] = &["all", "weak excitation", "misfit", "wrong unit", "matched"];

/// A curve over the length of the log: its name; then seconds of the log, figure, and whether it is that of the other program.
pub(super) type OverLength = (&'static str, &'static [(f64, &'static str, bool)]);

/// Curves of processor time and memory.
pub(super) const LENGTHS: &[OverLength] = &[
    (
        "identify, 2 joints",
        &[(10.0, "10 s", false), (1000.0, "1000 s", false)],
    ),
    (
        "NumPy, 2 joints",
        &[(10.0, "10 s", true), (1000.0, "1000 s", true)],
    ),
    (
        "identify, 7 joints",
        &[(15.0, "seven", false), (3600.0, "hour", false)],
    ),
    (
        "Pinocchio, 7 joints",
        &[(15.0, "seven", true), (3600.0, "hour", true)],
    ),
    (
        "refine, 7 joints",
        &[
            (15.0, "refined, 15 s", false),
            (60.0, "refined, 60 s", false),
        ],
    ),
];
