//! `crease`: scans of a clothed person in, an avatar out.

mod command;

use clap::{Parser, Subcommand};
use crease_trainer::interrupt::Interrupted;
use std::process::ExitCode;

#[derive(Parser)]
#[command(name = "crease", version, about = "Scans of a clothed person in, an animatable avatar out")]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Say what a sequence is like, and what would go wrong
    Check(command::check::Arguments),
    /// Make a sequence of a published layout's files
    Import(command::import::Arguments),
    /// Estimate shape and poses of the body from the scans alone
    Register(command::register::Arguments),
    /// Measure estimated shape and poses against the true ones
    Compare(command::compare::Arguments),
    /// Train an avatar on one or more sequences of a person in the same clothes
    Train(command::train::Arguments),
    /// Measure an avatar against a sequence's ground truth
    Eval(command::eval::Arguments),
    /// Write a page that shows how close an avatar comes, and where its error lies
    Report(command::report::Arguments),
    /// Write the meshes of an avatar in motion
    Animate(command::animate::Arguments),
    /// Draw an avatar in motion: a film, or pictures
    Render(command::render::Arguments),
    /// Vary one choice of the method and measure what it does
    Ablate(command::ablate::Arguments),
    /// Turn an avatar's perceptrons into tables
    Compact(command::compact::Arguments),
    /// Give an avatar the wrinkles of another
    Transfer(command::transfer::DetailArguments),
    /// Give an avatar the texture of another
    Texture(command::transfer::TextureArguments),
    /// Say what is inside an avatar
    Inspect(command::inspect::Arguments),
    /// Train the demo avatar again, from a copy of its sequence
    Demo(command::demo::Arguments),
}

fn main() -> ExitCode {
    // Whoever reads what is printed may have seen enough, as `head` has: that is no fault.
    sigpipe::reset();
    let result = match Arguments::parse().command {
        Command::Check(arguments) => command::check::run(&arguments),
        Command::Import(arguments) => command::import::run(&arguments),
        Command::Register(arguments) => command::register::run(&arguments),
        Command::Compare(arguments) => command::compare::run(&arguments),
        Command::Train(arguments) => command::train::run(&arguments),
        Command::Eval(arguments) => command::eval::run(&arguments),
        Command::Report(arguments) => command::report::run(&arguments),
        Command::Animate(arguments) => command::animate::run(&arguments),
        Command::Render(arguments) => command::render::run(&arguments),
        Command::Ablate(arguments) => command::ablate::run(&arguments),
        Command::Compact(arguments) => command::compact::run(&arguments),
        Command::Transfer(arguments) => command::transfer::detail(&arguments),
        Command::Texture(arguments) => command::transfer::texture(&arguments),
        Command::Inspect(arguments) => command::inspect::run(&arguments),
        Command::Demo(arguments) => command::demo::run(&arguments),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) if error.is::<Interrupted>() => {
            eprintln!("{error}");
            ExitCode::from(command::STOPPED)
        }
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}
