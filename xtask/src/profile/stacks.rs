//! Call stacks of a recorded profile.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

use super::stages::Function;

/// The call stacks of a profile.
pub(super) struct Stacks {
    // Addresses of each sample's frames within the program.
    samples: Vec<Vec<u64>>,
    // Functions at an address; several if some are inlined into others.
    functions: BTreeMap<u64, Vec<Function>>,
}

impl Stacks {
    /// Reads a profile; `None` if a program fails.
    ///
    /// - `recorded`: file that `perf record` wrote; `program`: the program that ran.
    pub(super) fn read(recorded: &Path, program: &Path) -> Option<Self> {
        let script = Command::new("perf")
            .args(["script", "--no-inline", "-F", "ip,sym,dso", "-i"])
            .arg(recorded)
            .stderr(Stdio::null())
            .output()
            .ok()?;
        let script = String::from_utf8_lossy(&script.stdout);
        let samples = samples(&script, program, shift(&headers(program)?)?);
        let functions = functions(&resolve(&samples, program)?);
        Some(Self { samples, functions })
    }

    /// Returns the functions of each sample.
    pub(super) fn functions(&self) -> Vec<Vec<&Function>> {
        let at = |address: &u64| self.functions.get(address).into_iter().flatten();
        (self.samples.iter())
            .map(|sample| sample.iter().flat_map(at).collect())
            .collect()
    }
}

/// Returns the addresses of each sample within the program, from the text of `perf script`.
///
/// - `shift`: address minus place in the file, which `perf script` prints.
fn samples(script: &str, program: &Path, shift: u64) -> Vec<Vec<u64>> {
    let ending = format!("({})", program.display());
    (script.split("\n\n"))
        .filter(|sample| !sample.trim().is_empty())
        .map(|sample| {
            let frames = sample.lines().enumerate();
            frames
                .filter(|(_, line)| line.ends_with(&ending))
                .filter_map(|(i, line)| Some(place(i, line)? + shift))
                .collect()
        })
        .collect()
}

/// Returns the place of a call. A caller's frame contains the address after the call, which may
/// belong to another function.
fn place(frame: usize, line: &str) -> Option<u64> {
    let digits = line.split_whitespace().next()?;
    let place = u64::from_str_radix(digits, 16).ok()?;
    Some(place - u64::from(frame > 0 && place > 0))
}

/// Returns the text of `readelf` about the segments of a program.
fn headers(program: &Path) -> Option<String> {
    let mut command = Command::new("readelf");
    let output = command
        .args(["--program-headers", "--wide"])
        .arg(program)
        .output();
    Some(String::from_utf8_lossy(&output.ok()?.stdout).into_owned())
}

/// Returns the address of the program's code minus its place in the file.
fn shift(headers: &str) -> Option<u64> {
    let code = headers
        .lines()
        .find(|line| line.contains("LOAD") && line.contains("R E"))?;
    let number = |word: &str| u64::from_str_radix(word.strip_prefix("0x")?, 16).ok();
    let mut numbers = code.split_whitespace().skip(1).map_while(number);
    let (place, address) = (numbers.next()?, numbers.next()?);
    Some(address - place)
}

/// Returns the text of `addr2line` for all addresses of some samples.
fn resolve(samples: &[Vec<u64>], program: &Path) -> Option<String> {
    let addresses: BTreeSet<&u64> = samples.iter().flatten().collect();
    let mut child = Command::new("addr2line")
        .args([
            "--addresses",
            "--functions",
            "--inlines",
            "--demangle",
            "-e",
        ])
        .arg(program)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .ok()?;
    let mut input = child.stdin.take()?;
    let lines: Vec<u8> = (addresses.iter())
        .flat_map(|address| format!("{address:x}\n").into_bytes())
        .collect();
    let writer = std::thread::spawn(move || input.write_all(&lines));
    let output = child.wait_with_output().ok()?;
    writer.join().ok()?.ok()?;
    Some(String::from_utf8_lossy(&output.stdout).into_owned())
}

/// Returns the functions at each address, from the text of `addr2line`: an address, then pairs of a
/// function and its place.
fn functions(resolved: &str) -> BTreeMap<u64, Vec<Function>> {
    let mut all = BTreeMap::<u64, Vec<Function>>::new();
    let mut address = 0;
    let mut lines = resolved.lines();
    while let Some(line) = lines.next() {
        if let Some(digits) = line.strip_prefix("0x") {
            address = u64::from_str_radix(digits, 16).unwrap_or_default();
            continue;
        }
        let place = lines.next().unwrap_or_default();
        let file = place.rsplit_once(':').map_or(place, |(file, _)| file);
        all.entry(address).or_default().push(Function {
            name: line.to_owned(),
            file: file.to_owned(),
        });
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_of_perf_and_addr2line_are_understood() {
        let script = "\
\t         150224a fold (/t/sprung)\n\t   7f0c memcpy (/lib/libc.so)\n\
\t         1502300 sprung::fit (/t/sprung)\n\n\
\t         138306d gemm (/t/sprung)\n\t  0 [unknown] ([unknown])\n\n";
        let headers =
            "  LOAD 0x000000 0x0000000000000000 0x0000000000000000 0x4fb0d0 0x4fb0d0 R   0x1000
  LOAD 0x4fb100 0x00000000004fc100 0x00000000004fc100 0x1161d10 0x1161d10 R E 0x1000";
        let found = samples(script, Path::new("/t/sprung"), shift(headers).unwrap());
        assert_eq!(found, [vec![0x0150_324a, 0x0150_32ff], vec![0x0138_406d]]);
        let resolved = "0x000000000150224a\nfold\n/rustc/core/iter.rs:?\nsprung::fit\n\
                        /w/crates/sprung/src/fit.rs:12\n0x138306d\ngemm\n??:0\n";
        let all = functions(resolved);
        let inlined: Vec<&str> = all[&0x0150_224a].iter().map(|f| f.name.as_str()).collect();
        assert_eq!(inlined, ["fold", "sprung::fit"]);
        assert_eq!(all[&0x0150_224a][1].file, "/w/crates/sprung/src/fit.rs");
        assert_eq!(all[&0x0138_306d][0].file, "??");
    }
}
