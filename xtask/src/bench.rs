//! `bench`: what a frame costs, natively and in a page, and how large things are; one table, and `target/bench.json`.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use clap::Args;
use serde_json::{Map, Value, json};

use crate::{browser, check, command, progress, setup, size, wasm, workspace};

/// The avatar that is measured, relative to the root.
const AVATAR: &str = "web/assets/shirt-dancer.glb";

/// What it dances, relative to the root.
const MOTION: &str = "web/assets/motions/dance_a.pkl";

/// A page of the demo avatar alone, at a fixed quality.
const PAGE: &str = "tests/pages/bench.html";

/// Frames that a page draws before its medians are read.
const FRAMES: u32 = 60;

/// What to measure.
#[derive(Args)]
pub struct Options {
    /// Measure the compute passes as well, on whatever adapter there is
    #[arg(long)]
    gpu: bool,
    /// Leave the browser out
    #[arg(long)]
    no_page: bool,
}

/// Measures, prints a table and writes `target/bench.json`.
pub fn run(options: &Options) -> Result<()> {
    let toolchain = setup::everything()?;
    let mut figures = Figures::default();
    figures.put("machine", json!(machine()));
    figures.put("commit", json!(commit()?));
    figures.put("avatar_bytes", json!(fs::metadata(workspace::root().join(AVATAR))?.len()));
    native(&mut figures)?;
    if options.gpu {
        gpu(&mut figures)?;
    }
    if !options.no_page {
        wasm::build(toolchain)?;
        wasm::build_element()?;
        figures.put("runtime_gzip_bytes", json!(size::runtime_gzip_bytes()?));
        figures.put("threads_runtime_gzip_bytes", json!(size::threads_gzip_bytes()?));
        threads(&mut figures)?;
        pages(&mut figures)?;
    }
    let file = workspace::root().join("target/bench.json");
    fs::write(&file, serde_json::to_string_pretty(&figures.0)?)
        .with_context(|| format!("cannot write {}", workspace::relative(&file)))?;
    print!("{}", figures.table());
    eprintln!("Written to {}.", workspace::relative(&file));
    Ok(())
}

/// Flat keys and numbers or names.
#[derive(Default)]
struct Figures(Map<String, Value>);

impl Figures {
    fn put(&mut self, key: &str, value: Value) {
        self.0.insert(key.to_owned(), value);
    }

    /// Memory of a page's element: the module's, the GPU's, and both.
    fn put_memory(&mut self, key: &str, statistics: &Value) {
        let (wasm, gpu) = (statistics["memoryBytes"].as_u64(), statistics["gpuBytes"].as_u64());
        self.put(&format!("{key}_wasm"), json!(wasm));
        self.put(&format!("{key}_gpu"), json!(gpu));
        self.put(key, json!(wasm.zip(gpu).map(|(wasm, gpu)| wasm + gpu)));
    }

    /// A Markdown table, a row a figure.
    fn table(&self) -> String {
        let row = |(key, value): (&String, &Value)| match value {
            Value::String(text) => format!("| {key} | {text} |\n"),
            value => format!("| {key} | {value} |\n"),
        };
        std::iter::once("| figure | value |\n|---|---|\n".to_owned()).chain(self.0.iter().map(row)).collect()
    }
}

/// Runs the benchmarks of benches/ and takes their medians.
fn native(figures: &mut Figures) -> Result<()> {
    progress::aloud("Native benchmarks, one thread", || {
        let mut cargo = command::cargo("bench");
        command::run(cargo.args(["--package", "crease", "--bench", "frame"]))
    })?;
    let medians = medians(&workspace::root().join("target/criterion"))?;
    for (benchmark, key) in [
        ("frame", "frame_ms_native"),
        ("solve", "solve_ms"),
        ("solve directly", "solve_direct_ms"),
        ("solver setup", "solver_setup_ms"),
        ("animator setup", "animator_setup_ms"),
    ] {
        let Some(milliseconds) = medians.get(benchmark) else { bail!("the benchmark {benchmark} left no estimate") };
        figures.put(key, json!(to_hundredths(*milliseconds)));
    }
    for (benchmark, milliseconds) in &medians {
        if let Some((group, name)) = benchmark.split_once('/') {
            let key = format!("{group}_ms_native_{}", name.replace(' ', "_"));
            figures.put(&key, json!(to_hundredths(*milliseconds)));
        }
    }
    Ok(())
}

/// Median milliseconds of each benchmark that criterion has left in `folder`, by its full name.
fn medians(folder: &Path) -> Result<BTreeMap<String, f64>> {
    let mut medians = BTreeMap::new();
    let entries = fs::read_dir(folder).with_context(|| format!("cannot read {}", workspace::relative(folder)))?;
    for entry in entries {
        let latest = entry?.path().join("new");
        let (about, estimates) = (latest.join("benchmark.json"), latest.join("estimates.json"));
        if about.is_file() {
            let name =
                read_json(&about)?["full_id"].as_str().context("criterion's benchmark.json has no full_id")?.to_owned();
            let nanoseconds = read_json(&estimates)?["median"]["point_estimate"].as_f64();
            medians.insert(name, nanoseconds.context("criterion's estimates.json has no median")? / 1e6);
        }
    }
    Ok(medians)
}

fn read_json(file: &PathBuf) -> Result<Value> {
    let text = fs::read(file).with_context(|| format!("cannot read {}", workspace::relative(file)))?;
    serde_json::from_slice(&text).with_context(|| format!("{} is no JSON", workspace::relative(file)))
}

/// The compute passes by timestamp.
fn gpu(figures: &mut Figures) -> Result<()> {
    let told = progress::aloud("Compute passes on this machine's adapter", || {
        let mut cargo = command::cargo("run");
        cargo.args(["--release", "--package", "crease", "--example", "gpu_frame", "--features", "gpu", "--", AVATAR]);
        browser::lend_software_gpu(&mut cargo);
        command::output(&mut cargo)
    })?;
    let line = told.lines().last().context("the example printed nothing")?;
    let told: Value = serde_json::from_str(line).context("the example's last line is no JSON")?;
    figures.put("adapter", told["adapter"].clone());
    for (functions, key) in [("own", "compact"), ("plain", "plain")] {
        figures.put(&format!("frame_ms_gpu_{key}"), told[functions]["frame_ms"].clone());
        for (stage, milliseconds) in told[functions]["stages_ms"].as_object().into_iter().flatten() {
            figures.put(&format!("frame_ms_gpu_{key}_{stage}"), milliseconds.clone());
        }
    }
    Ok(())
}

/// The module on one thread and on as many as there are processors, outside of a browser: its renderer would have one of them.
fn threads(figures: &mut Figures) -> Result<()> {
    let root = workspace::root();
    let order = json!({
        "package": workspace::web().join("pkg"), "avatar": root.join(AVATAR), "motion": root.join(MOTION), "threads": processors()
    });
    let told = progress::aloud("Frames on several threads", || {
        let mut node = command::program("node");
        node.arg(workspace::web().join("tools/time_threads.mjs")).arg(order.to_string());
        command::output(&mut node)
    })?;
    let told: Value = serde_json::from_str(&told).context("tools/time_threads.mjs printed no JSON")?;
    for (key, value) in told.as_object().into_iter().flatten() {
        figures.put(key, value.as_f64().map_or(value.clone(), |number| json!(to_hundredths(number))));
    }
    Ok(())
}

/// The demo avatar in headless Chromium: on each backend, and several of it in one page.
fn pages(figures: &mut Figures) -> Result<()> {
    for (backend, key) in [("webgpu+cpu", "webgpu_cpu"), ("webgl2+cpu", "webgl2_cpu")] {
        let statistics =
            check::statistics(Path::new(PAGE), &format!("?backend={}", backend.replace('+', "%2B")), FRAMES)?;
        if statistics["backend"] != json!(backend) {
            bail!("asked for {backend}, the page runs {}", statistics["backend"]);
        }
        figures.put(&format!("frame_ms_page_{key}"), statistics["frameMilliseconds"].clone());
        figures.put(&format!("draw_ms_page_{key}"), statistics["drawMilliseconds"].clone());
        if key == "webgpu_cpu" {
            figures.put("frame_ms_wasm_cpu", statistics["poseMilliseconds"].clone());
            for (part, milliseconds) in statistics["partMilliseconds"].as_object().into_iter().flatten() {
                figures.put(&format!("frame_ms_wasm_{part}"), milliseconds.clone());
            }
            figures.put("iterations_wasm", statistics["iterations"].clone());
            figures.put("solver_setup_ms_wasm", statistics["detailSetupMilliseconds"].clone());
            figures.put_memory("memory_bytes", &statistics);
        }
    }
    // Whatever the adapter, as much is held.
    figures.put_memory("memory_bytes_webgpu", &check::statistics(Path::new(PAGE), "?backend=webgpu", 2)?);
    // As a page has it that demands no quality: the base comes first.
    let statistics = check::statistics(Path::new(PAGE), "?backend=webgpu%2Bcpu&quality=auto", FRAMES)?;
    figures.put("first_frame_ms", statistics["firstFrameMilliseconds"].clone());
    figures.put("first_detail_ms", statistics["firstDetailMilliseconds"].clone());
    for count in [1, 2, 4, 8] {
        let statistics =
            check::statistics(Path::new(PAGE), &format!("?backend=webgpu%2Bcpu&count={count}"), FRAMES / 4)?;
        figures.put(&format!("frame_ms_page_{count}_avatars"), statistics["frameMilliseconds"].clone());
        figures.put(&format!("pose_ms_page_{count}_avatars"), statistics["poseMilliseconds"].clone());
    }
    Ok(())
}

/// The processor's name, and how many of it.
fn machine() -> String {
    let processors = processors();
    let described = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = described.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    format!("{} × {}", processors, model.map_or(std::env::consts::ARCH, |(_, name)| name.trim()))
}

fn processors() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

fn commit() -> Result<String> {
    let told = command::output(
        command::program("git").args(["describe", "--always", "--dirty"]).current_dir(workspace::root()),
    )?;
    Ok(told.trim().to_owned())
}

fn to_hundredths(milliseconds: f64) -> f64 {
    (100.0 * milliseconds).round() / 100.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_are_read_in_milliseconds_by_their_full_names() {
        let folder = std::env::temp_dir().join(format!("crease-bench-{}", std::process::id()));
        let latest = folder.join("frame_solve/new");
        fs::create_dir_all(&latest).unwrap();
        fs::write(latest.join("benchmark.json"), r#"{"full_id": "frame/solve"}"#).unwrap();
        fs::write(latest.join("estimates.json"), r#"{"median": {"point_estimate": 2500000.0}}"#).unwrap();
        assert_eq!(medians(&folder).unwrap(), BTreeMap::from([("frame/solve".to_owned(), 2.5)]));
        fs::write(latest.join("estimates.json"), "{}").unwrap();
        assert!(medians(&folder).unwrap_err().to_string().contains("no median"));
        fs::remove_dir_all(&folder).unwrap();
        assert!(medians(&folder).is_err(), "nothing was measured");
    }

    #[test]
    fn the_table_has_a_row_for_each_figure() {
        let mut figures = Figures::default();
        figures.put("solve_ms", json!(21.5));
        figures.put("adapter", json!("none"));
        assert_eq!(figures.table(), "| figure | value |\n|---|---|\n| adapter | none |\n| solve_ms | 21.5 |\n");
    }
}
