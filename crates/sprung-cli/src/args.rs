//! Arguments of the command line.

use std::ffi::OsStr;
use std::path::PathBuf;

use clap::builder::{PossibleValue, TypedValueParser};
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Arg, Args, Command, Parser, Subcommand, ValueEnum};
use sprung::export::Format;

/// The version, with the commit if the source was a clone.
const VERSION: &str = env!("SPRUNG_VERSION");

const EXIT_CODES: &str = "Exit codes:
  0  done
  1  done, but the verdict is unusable (all results were written)
  2  the command line or the experiment file is wrong
  3  a log is wrong
  4  a file cannot be read or written";

/// Identifies the dynamic parameters of flexible-joint robots from measured logs.
#[derive(Debug, Parser)]
#[command(name = "sprung", version = VERSION, after_help = EXIT_CODES, max_term_width = 100)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) verb: Verb,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Verb {
    /// Run the paper's experiment, end to end, on a digital twin.
    #[command(before_help = "Example: sprung demo --out my-demo")]
    Demo(Demo),
    /// Write a commented experiment.toml to start from, for your own robot.
    #[command(before_help = "Example: sprung new my-arm --urdf arm.urdf --log run.mcap")]
    New(New),
    /// Check a log before any fit: rate, units, signs, delays, faults.
    #[command(before_help = "Example: sprung check experiment.toml --set log.file=run7.csv")]
    Check(Check),
    /// Identify the parameters of a robot from a log.
    #[command(before_help = "Example: sprung identify experiment.toml --set log.file=run7.csv")]
    Identify(Identify),
    /// Test identified parameters on other logs, by simulation.
    #[command(
        before_help = "Example: sprung validate experiment.toml --parameters sprung-out/identification.json"
    )]
    Validate(Validate),
    /// Watch a running robot: contacts, changes of the robot, sensors that show nothing.
    #[command(before_help = "Example: sprung watch experiment.toml --log today.csv")]
    Watch(Watch),
    /// Compare results of one robot: estimators, settings, runs, drift over time.
    #[command(
        before_help = "Example: sprung compare run1/sprung-out/identification.json run2/sprung-out/identification.json"
    )]
    Compare(Compare),
    /// Simulate a log with the digital twin that an experiment describes.
    #[command(before_help = "Example: sprung simulate experiment.toml --set simulate.seed=7")]
    Simulate(Simulate),
    /// Design the motion to record: within all limits, with promised errors.
    #[command(before_help = "Example: sprung excite experiment.toml --out design")]
    Excite(Excite),
    /// Design a controller for an identified robot, and prove it.
    #[command(
        before_help = "Example: sprung control experiment.toml --set control.bandwidth_hz=[3.0]"
    )]
    Control(Control),
    /// Write an identified robot for simulators and controllers.
    #[command(before_help = "Example: sprung export experiment.toml --format mjcf")]
    Export(Export),
    /// Explain a finding: its cause, its condition and its remedy.
    #[command(before_help = "Example: sprung explain weakly-excited")]
    Explain(Explain),
    /// Print the JSON schema of experiment.toml, for editors.
    #[command(before_help = "Example: sprung schema > experiment.schema.json")]
    Schema,
    /// Print completions of the command line, for a shell.
    #[command(
        before_help = "Example: sprung completions bash > ~/.local/share/bash-completion/completions/sprung"
    )]
    Completions(Completions),
    /// Print the manual page of sprung or of a verb, for man.
    #[command(before_help = "Example: sprung man identify | man -l -")]
    Man(ManPage),
}

impl Verb {
    /// Returns whether results and errors are printed as JSON.
    pub(crate) fn wants_json(&self) -> bool {
        match self {
            Self::Check(Check { common, .. })
            | Self::Identify(Identify { common, .. })
            | Self::Validate(Validate { common, .. })
            | Self::Watch(Watch { common, .. })
            | Self::Simulate(Simulate { common, .. })
            | Self::Excite(Excite { common, .. })
            | Self::Control(Control { common, .. })
            | Self::Export(Export { common, .. }) => common.json,
            Self::Compare(args) => args.json,
            Self::Explain(args) => args.json,
            Self::Demo(_) | Self::New(_) | Self::Schema | Self::Completions(_) | Self::Man(_) => {
                false
            }
        }
    }
}

#[derive(Debug, Args)]
pub(crate) struct Explain {
    /// Code of the finding or of the refusal.
    #[arg(required_unless_present = "list")]
    pub(crate) code: Option<String>,
    /// Print all codes, one a line.
    #[arg(long, conflicts_with = "code")]
    pub(crate) list: bool,
    /// Print the explanation, or all explanations, as JSON.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct Completions {
    /// Shell: bash, zsh, fish, powershell or elvish.
    #[arg(value_name = "SHELL")]
    pub(crate) shell: clap_complete::Shell,
}

#[derive(Debug, Args)]
pub(crate) struct ManPage {
    /// Verb of the page [default: the page of sprung].
    #[arg(value_name = "VERB")]
    pub(crate) verb: Option<String>,
}

#[derive(Debug, Args)]
pub(crate) struct Common {
    /// Folder for results [default: sprung-out beside experiment.toml, sprung-out-NAME beside
    /// NAME.toml; simulate: the folder in which the experiment names its log].
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Override one key of the experiment, for example log.file=run7.csv; can be repeated.
    #[arg(long = "set", value_name = "KEY.PATH=VALUE")]
    pub(crate) overrides: Vec<String>,
    /// Print only the results on stdout, and errors on stderr, as JSON.
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) voice: Voice,
    #[command(flatten)]
    pub(crate) work: Work,
}

#[derive(Clone, Copy, Debug, Args)]
pub(crate) struct Work {
    /// Number of threads; results do not depend on it [default: one per processor].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=256))]
    pub(crate) threads: Option<u16>,
}

#[derive(Clone, Copy, Debug, Args)]
pub(crate) struct Voice {
    /// Print only errors.
    #[arg(short, long)]
    pub(crate) quiet: bool,
    /// Print notes as well as warnings.
    #[arg(short, long)]
    pub(crate) verbose: bool,
    /// Draw no progress bar.
    #[arg(long)]
    pub(crate) no_progress: bool,
    /// When to colour the verdict.
    #[arg(long, value_enum, default_value_t = Color::Auto)]
    pub(crate) color: Color,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Color {
    Auto,
    Always,
    Never,
}

#[derive(Debug, Args)]
pub(crate) struct Demo {
    /// Folder for the experiment and its results.
    #[arg(long, value_name = "DIR", default_value = "sprung-demo")]
    pub(crate) out: PathBuf,
    /// Seed of encoder phases and noise.
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    #[command(flatten)]
    pub(crate) voice: Voice,
    #[command(flatten)]
    pub(crate) work: Work,
}

#[derive(Debug, Args)]
pub(crate) struct New {
    /// Folder for experiment.toml; created if it does not exist.
    #[arg(value_name = "DIR")]
    pub(crate) folder: PathBuf,
    /// URDF file of the robot; the file is not copied.
    #[arg(long, value_name = "FILE", conflicts_with = "joints")]
    pub(crate) urdf: Option<PathBuf>,
    /// Number of joints, 1 to 32, of a robot whose Denavit-Hartenberg table you fill in [default:
    /// that of the log, otherwise 2].
    #[arg(long, value_name = "N")]
    pub(crate) joints: Option<usize>,
    /// Log of the robot; its names and values decide the columns, units and sides. Can be repeated
    /// for several logs with the same columns.
    #[arg(long, value_name = "FILE")]
    pub(crate) log: Vec<PathBuf>,
    /// Use only the topics of a bag that begin with this, if it has several robots.
    #[arg(long, value_name = "BEGINNING", requires = "log")]
    pub(crate) topics: Option<String>,
    #[command(flatten)]
    pub(crate) voice: Voice,
}

#[derive(Debug, Args)]
pub(crate) struct Check {
    /// Experiment file, or the folder that holds experiment.toml.
    pub(crate) experiment: PathBuf,
    #[command(flatten)]
    pub(crate) common: Common,
}

#[derive(Debug, Args)]
#[command(
    override_usage = "sprung identify [OPTIONS] <EXPERIMENT>\n       sprung identify [OPTIONS] --urdf <FILE> --log <FILE>"
)]
pub(crate) struct Identify {
    /// Experiment file, or the folder that holds experiment.toml.
    #[arg(required_unless_present_any = ["urdf", "log"])]
    pub(crate) experiment: Option<PathBuf>,
    /// URDF file of a robot without an experiment file, with --log. Writes the experiment.toml of
    /// sprung new into --out [default: sprung-LOG, with the name of the log], and the results into
    /// sprung-out beside it. Ends with exit code 3 if the log leaves a line to fill in.
    #[arg(long, value_name = "FILE")]
    pub(crate) urdf: Option<PathBuf>,
    /// Log of the robot of --urdf; can be repeated for several logs with the same columns.
    #[arg(long, value_name = "FILE")]
    pub(crate) log: Vec<PathBuf>,
    /// Use only the topics of a bag that begin with this, if it has several robots.
    #[arg(long, value_name = "BEGINNING", requires = "log")]
    pub(crate) topics: Option<String>,
    /// Replace another experiment.toml in the folder of --urdf and --log.
    #[arg(long, requires = "urdf")]
    pub(crate) force: bool,
    /// Use the laws of friction and springs of an earlier identification, and look for no others; repeated, their
    /// union. Results of several runs then have one model.
    #[arg(long, value_name = "identification.json")]
    pub(crate) laws_from: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) common: Common,
}

#[derive(Debug, Args)]
pub(crate) struct Validate {
    /// Experiment file, or the folder that holds experiment.toml.
    pub(crate) experiment: PathBuf,
    /// identification.json, or a TOML file with values by name [default: identification.json in
    /// the results folder].
    #[arg(long, value_name = "FILE")]
    pub(crate) parameters: Option<PathBuf>,
    /// Take values that sprung identify is still refining, or that a stopped refinement left.
    #[arg(long)]
    pub(crate) accept_refining: bool,
    #[command(flatten)]
    pub(crate) common: Common,
}

#[derive(Debug, Args)]
pub(crate) struct Watch {
    /// Experiment file, or the folder that holds experiment.toml. Its logs are those of the healthy robot.
    pub(crate) experiment: PathBuf,
    /// Log to watch, a folder of logs, or - for CSV on standard input; can be repeated. Without a log only the thresholds are
    /// printed.
    #[arg(long, value_name = "FILE|DIR|-")]
    pub(crate) log: Vec<PathBuf>,
    /// Wait for more at the end of a log that is being written, and end after so many seconds without more.
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    pub(crate) follow: Option<f64>,
    /// Promised false alarms per hour, of all joints together.
    #[arg(long, value_name = "NUMBER", default_value_t = 1.0, value_parser = positive)]
    pub(crate) false_alarms_per_h: f64,
    /// identification.json [default: the one in the results folder].
    #[arg(long, value_name = "FILE")]
    pub(crate) parameters: Option<PathBuf>,
    /// Take values whose verdict is unusable.
    #[arg(long)]
    pub(crate) accept_unusable: bool,
    /// Take values that sprung identify is still refining, or that a stopped refinement left.
    #[arg(long)]
    pub(crate) accept_refining: bool,
    #[command(flatten)]
    pub(crate) common: Common,
}

#[derive(Debug, Args)]
pub(crate) struct Compare {
    /// Two or more identification.json or their folders, or a single file that contains several
    /// results. All results are compared with the first; four or more runs are tested for drift. Files or folders with a validation.json
    /// add how often promises were kept.
    #[arg(value_name = "FILE", required = true)]
    pub(crate) files: Vec<PathBuf>,
    /// Folder for comparison.json and report.html.
    #[arg(long, value_name = "DIR", default_value = "sprung-comparison")]
    pub(crate) out: PathBuf,
    /// Print only the comparison on stdout, and errors on stderr, as JSON.
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) voice: Voice,
}

#[derive(Debug, Args)]
pub(crate) struct Simulate {
    /// Experiment file, or the folder that holds experiment.toml.
    pub(crate) experiment: PathBuf,
    /// Use the controller and the log of this validation run instead of the experiment's own.
    #[arg(long, value_name = "NAME")]
    pub(crate) run: Option<String>,
    /// Parameters of the twin: identification.json, or a TOML file with values by name [default:
    /// those of the simulate block].
    #[arg(long, value_name = "FILE")]
    pub(crate) parameters: Option<PathBuf>,
    /// Also print the standard errors that this motion buys with these sensors, the bound of Cramér and Rao.
    #[arg(long)]
    pub(crate) expected_errors: bool,
    #[command(flatten)]
    pub(crate) common: Common,
}

#[derive(Debug, Args)]
pub(crate) struct Excite {
    /// Experiment file, or the folder that holds experiment.toml.
    pub(crate) experiment: PathBuf,
    /// What makes the motion: optimal (a search), paper (the reference of the founding paper) or random (a random series
    /// as large as the limits allow); the last two are judged without a search.
    #[arg(long, value_enum, default_value_t = Method::Optimal, value_name = "METHOD")]
    pub(crate) method: Method,
    /// A file with a [controller.reference], such as reference.toml of another design: its motion is judged instead of a
    /// new one.
    #[arg(long, value_name = "FILE", conflicts_with = "method")]
    pub(crate) reference: Option<PathBuf>,
    /// Values of the robot: identification.json, or a TOML file with values by name [default: identification.json in the
    /// results folder, else the nominal values].
    #[arg(long, value_name = "FILE")]
    pub(crate) parameters: Option<PathBuf>,
    /// A first small motion for an unknown robot: a part of all limits, usual values for drives that the file does not
    /// describe.
    #[arg(long)]
    pub(crate) warm_up: bool,
    /// A recorded log with the columns of [log]: the new motion adds to what it tells.
    #[arg(long, value_name = "FILE")]
    pub(crate) from_log: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) common: Common,
}

#[derive(Debug, Args)]
pub(crate) struct Control {
    /// Experiment file, or the folder that holds experiment.toml.
    pub(crate) experiment: PathBuf,
    /// Values of the robot: identification.json, or a TOML file with values by name, which count as exact [default:
    /// identification.json in the results folder].
    #[arg(long, value_name = "FILE")]
    pub(crate) parameters: Option<PathBuf>,
    /// Design also with values whose verdict is unusable; control.json and the exported code then say so.
    #[arg(long)]
    pub(crate) accept_unusable: bool,
    /// Take values that sprung identify is still refining, or that a stopped refinement left.
    #[arg(long)]
    pub(crate) accept_refining: bool,
    #[command(flatten)]
    pub(crate) common: Common,
}

/// What makes a motion.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum Method {
    Optimal,
    Paper,
    Random,
}

#[derive(Debug, Args)]
pub(crate) struct Export {
    /// Experiment file, or the folder that holds experiment.toml.
    pub(crate) experiment: PathBuf,
    /// Format: urdf (robot.urdf), mjcf (robot.xml, of MuJoCo), sdf (robot.sdf, of Drake), json
    /// (robot.json, parameters of links and actuators), c (robot.h, robot.c and a test) or rust
    /// (robot.rs, without the standard library).
    #[arg(long, value_parser = FormatParser, value_name = "FORMAT")]
    pub(crate) format: Format,
    /// identification.json, or a TOML file with values by name [default: identification.json in
    /// the results folder].
    #[arg(long, value_name = "FILE")]
    pub(crate) parameters: Option<PathBuf>,
    /// control.json of a designed controller, which the code in C or Rust then contains.
    #[arg(long, value_name = "FILE")]
    pub(crate) control: Option<PathBuf>,
    /// watch.json of sprung watch, whose observer of torques from outside the code in C or Rust then contains.
    #[arg(long, value_name = "FILE")]
    pub(crate) watch: Option<PathBuf>,
    /// Write one joint with the rotor's inertia in place of motor, spring and link.
    #[arg(long)]
    pub(crate) rigid: bool,
    /// Replace a file that was edited since the last export, or that no export wrote.
    #[arg(long)]
    pub(crate) force: bool,
    /// Take values that sprung identify is still refining, or that a stopped refinement left.
    #[arg(long)]
    pub(crate) accept_refining: bool,
    #[command(flatten)]
    pub(crate) common: Common,
}

/// Reads the word of a format. The error names all formats and no similar word: "usd" is not "rust".
#[derive(Clone)]
struct FormatParser;

impl TypedValueParser for FormatParser {
    type Value = Format;

    fn parse_ref(
        &self,
        command: &Command,
        argument: Option<&Arg>,
        value: &OsStr,
    ) -> Result<Format, clap::Error> {
        let word = value.to_string_lossy();
        Format::of_word(&word).ok_or_else(|| {
            let mut error = clap::Error::new(ErrorKind::InvalidValue).with_cmd(command);
            let name = argument.map_or_else(|| "--format".to_owned(), ToString::to_string);
            let all = Format::ALL.map(|format| format.word().to_owned()).to_vec();
            error.insert(ContextKind::InvalidArg, ContextValue::String(name));
            error.insert(
                ContextKind::InvalidValue,
                ContextValue::String(word.into_owned()),
            );
            error.insert(ContextKind::ValidValue, ContextValue::Strings(all));
            error
        })
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        let all = Format::ALL.map(|format| PossibleValue::new(format.word()));
        Some(Box::new(all.into_iter()))
    }
}

/// Reads a positive number.
fn positive(word: &str) -> Result<f64, String> {
    let number = word.parse::<f64>().ok();
    number
        .filter(|number| number.is_finite() && *number > 0.0)
        .ok_or_else(|| "give a positive number".to_owned())
}
