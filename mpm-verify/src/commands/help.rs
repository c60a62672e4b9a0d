//! Help: every command fits one screen and has examples; `mpm-verify help advanced` lists the options that are rarely needed.

use clap::{Command, CommandFactory};

use super::Failure;
use super::terminal::say;
use crate::Cli;

/// Commands with examples, each with what it does.
const EXAMPLES: [(&str, &[(&str, &str)]); 18] = [
    (
        "levee",
        &[
            ("mpm-verify levee", "the levee of the paper's section 4"),
            ("mpm-verify levee --variant saturation-0.7 --safety-factor 7,9", "one input changed"),
            ("mpm-verify levee --ensemble 9 --probability", "medians of equal runs; probability of failure over time"),
        ],
    ),
    (
        "slope",
        &[
            ("mpm-verify slope griffiths-lane-1", "one slope; a file of your own will do as well"),
            ("mpm-verify slope levee --after 14", "after water has seeped until 14 h on its clock"),
            ("mpm-verify slope --only acads-1a,taylor-cut", "two published slopes; without names all of them"),
        ],
    ),
    (
        "study",
        &[
            ("mpm-verify study", "all meshes, integrators and schemes"),
            ("mpm-verify study --integrator quasi-static --mesh 0.1,0.05", "one integrator on two meshes"),
        ],
    ),
    (
        "check",
        &[
            ("mpm-verify check terzaghi mandel", "two test cases; without a name all of them"),
            ("mpm-verify check --quick", "what takes no more than a second a case"),
            ("mpm-verify check --scene dam --rows 10,20,40", "a scene against its exact solution"),
        ],
    ),
    (
        "cases",
        &[
            ("mpm-verify cases export my-cases", "each case as case.json and a page"),
            ("mpm-verify cases answer my-cases/mandel/case.json answers", "the answer of this program"),
        ],
    ),
    (
        "score",
        &[
            ("mpm-verify score results/my-code", "results that lie there, a folder for each case"),
            ("mpm-verify score --run \"./my-code {case} {out} {refinement}\" --name my-code", "run it, measured"),
        ],
    ),
    ("leaderboard", &[("mpm-verify leaderboard reports/scores/mpm-verify reports/scores/my-code", "all on one page")]),
    (
        "solve",
        &[
            ("mpm-verify solve terzaghi", "a scene that comes with the program"),
            ("mpm-verify solve my-scene.toml --integrator quasi-static", "a scene file of your own"),
        ],
    ),
    ("gallery", &[("mpm-verify gallery footing rain", "two scenes; without a name all ten")]),
    (
        "stability",
        &[
            ("mpm-verify stability --quick", "the default schemes and the ends of every range"),
            ("mpm-verify stability hourglass", "one stress test"),
        ],
    ),
    (
        "nightly",
        &[
            ("mpm-verify nightly", "all parts"),
            ("mpm-verify nightly --only study,levee", "two of them, without recording them"),
            ("mpm-verify nightly --accept WHY --from reports/nightly/DATE", "renew the baselines"),
        ],
    ),
    (
        "prove",
        &[
            ("mpm-verify prove", "all parts, from the root of the source"),
            ("mpm-verify prove format lints", "two of them"),
        ],
    ),
    ("report", &[("mpm-verify report reports/accuracy", "the page and plots of a study that was run before")]),
    ("publish", &[("mpm-verify publish levee", "the levee alone; without a name all reports")]),
    (
        "list",
        &[
            ("mpm-verify list scenes", "one kind"),
            ("mpm-verify list --capabilities", "what can be combined in a scene"),
        ],
    ),
    (
        "mutants",
        &[
            ("mpm-verify mutants --list", "names of the faults"),
            ("mpm-verify mutants", "plant and find all of them"),
            ("mpm-verify mutants --share 1/10 --seed 7", "a random tenth of them"),
        ],
    ),
    (
        "metamorphic",
        &[
            ("mpm-verify metamorphic --scenes 50 --seed 7", "fifty other scenes"),
            ("mpm-verify metamorphic --seed 7 --only 12", "one scene of them again"),
        ],
    ),
    (
        "merge",
        &[
            ("mpm-verify study --shard 1/2 --out shares/1", "each share, on any machine"),
            ("mpm-verify merge shares/1 shares/2", "then the report of all"),
        ],
    ),
];

/// The command line with examples in its help.
pub fn cli() -> Command {
    // The options of the study belong to `study --help`; without a command they are accepted all the same.
    let cli = Cli::command().mut_args(|option| option.hide(true));
    let advanced = advanced(&cli);
    let cli = cli.after_help(examples(&[
        ("mpm-verify levee", "the first thing to try"),
        ("mpm-verify", "the accuracy study; its options: mpm-verify study --help"),
    ]));
    let cli = EXAMPLES.iter().fold(cli, |cli, (name, own)| {
        cli.mut_subcommand(name, |command| {
            let more = command.get_arguments().any(clap::Arg::is_hide_set);
            let more = if more { "\nMore options: mpm-verify help advanced" } else { "" };
            command.after_help(examples(own) + more)
        })
    });
    cli.mut_subcommand("advanced", |command| command.override_help(advanced))
}

/// Prints the options that are rarely needed.
pub fn run() -> Result<(), Failure> {
    say(advanced(&Cli::command()).trim_end());
    Ok(())
}

fn examples(lines: &[(&str, &str)]) -> String {
    let width = lines.iter().map(|(line, _)| line.len()).max().unwrap_or_default();
    let line = |(line, what): &(&str, &str)| format!("\n  {line:<width$}  {what}");
    let lines: String = lines.iter().map(line).collect();
    format!("Examples:{lines}")
}

/// The hidden options of all commands.
fn advanced(cli: &Command) -> String {
    let mut blocks = Vec::new();
    for command in cli.get_subcommands() {
        let hidden = command.get_arguments().filter(|option| option.is_hide_set());
        let line = |option: &clap::Arg| {
            let value = option.get_value_names().filter(|_| option.get_action().takes_values());
            let value = value.map_or_else(String::new, |names| format!(" <{}>", names.join(" ")));
            let help = option.get_help().map(ToString::to_string).unwrap_or_default();
            Some(format!("  {:<28}{help}\n", format!("--{}{value}", option.get_long()?)))
        };
        let lines: String = hidden.filter_map(line).collect();
        if !lines.is_empty() {
            blocks.push(format!("mpm-verify {}\n{lines}", command.get_name()));
        }
    }
    format!("Options that are rarely needed\n{}", blocks.join("\n"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lines and columns of a screen.
    const SCREEN: [usize; 2] = [40, 100];

    fn fits(name: &str, text: &str) {
        let columns = text.lines().map(|line| line.chars().count()).max().unwrap_or_default();
        let found = [text.lines().count(), columns];
        assert!(found[0] <= SCREEN[0] && found[1] <= SCREEN[1], "{name}: {found:?}\n{text}");
    }

    #[test]
    fn help_of_every_command_fits_one_screen_and_has_an_example() {
        let cli = cli().term_width(SCREEN[1]);
        let order: Vec<&str> = cli.get_subcommands().filter(|c| !c.is_hide_set()).map(Command::get_name).collect();
        assert_eq!(order, EXAMPLES.map(|(name, _)| name));
        let shown = |words: &[&str]| {
            let words = [&["mpm-verify"], words].concat();
            cli.clone().try_get_matches_from(words).expect_err("help").to_string()
        };
        for flag in ["-h", "--help"] {
            fits("mpm-verify", &shown(&[flag]));
            assert!(shown(&[flag]).contains("the first thing to try"));
            for (name, _) in EXAMPLES {
                let text = shown(&[name, flag]);
                fits(name, &text);
                assert!(text.contains("Examples:\n  mpm-verify "), "{name}: {text}");
                assert!(!text.to_lowercase().contains("everything"), "{name}: expected what it runs by name: {text}");
            }
        }
        let text = shown(&["help", "advanced"]);
        fits("advanced", &text);
        assert!(text.contains("--shard <I/N>"), "{text}");
    }

    #[test]
    fn examples_parse_and_hidden_options_are_listed() {
        use clap::Parser;
        for (line, _) in EXAMPLES.iter().flat_map(|(_, own)| *own) {
            let words = crate::promised::words(line);
            Cli::try_parse_from(&words).unwrap_or_else(|e| panic!("{line}: {e}"));
        }
        let (cli, text) = (Cli::command(), advanced(&Cli::command()));
        let hidden = cli.get_subcommands().flat_map(Command::get_arguments).filter(|option| option.is_hide_set());
        let hidden: Vec<&str> = hidden.filter_map(clap::Arg::get_long).collect();
        assert!(!hidden.is_empty() && hidden.iter().all(|name| text.contains(&format!("  --{name} "))), "{text}");
    }
}
