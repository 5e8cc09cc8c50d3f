//! Programs and libraries that tests need, installed where the machine is a Debian.

use std::path::Path;
use std::process::Command;

/// Installs Chromium; returns whether a browser is there.
pub(crate) fn browser() -> bool {
    let programs = [
        "/usr/bin/chromium",
        "/usr/bin/chromium-browser",
        "/usr/bin/google-chrome",
    ];
    ensure("Chromium", "tests of the report", "chromium", || {
        any_exists(&programs)
    })
}

/// Installs libhdf5; returns whether it is there.
pub(crate) fn hdf5() -> bool {
    let headers = ["/usr/include/hdf5/serial/hdf5.h", "/usr/include/hdf5.h"];
    let (tests, packages) = ("tests of MATLAB 7.3", "libhdf5-dev pkg-config");
    ensure("libhdf5", tests, packages, || {
        std::env::var_os("HDF5_DIR").is_some() || any_exists(&headers)
    })
}

/// Installs a compiler for Cortex-M, its C library and QEMU; returns whether they are there.
pub(crate) fn arm() -> bool {
    let programs = [
        "/usr/bin/arm-none-eabi-gcc",
        "/usr/bin/qemu-system-arm",
        "/usr/lib/arm-none-eabi/lib/thumb/v7e-m+fp/hard/libm.a",
        "/usr/lib/arm-none-eabi/lib/thumb/v7e-m+dp/hard/libm.a",
    ];
    let packages = "gcc-arm-none-eabi libnewlib-arm-none-eabi qemu-system-arm";
    ensure(
        "GCC for Cortex-M and QEMU",
        "tests on microcontrollers",
        packages,
        || programs.iter().all(|path| Path::new(path).exists()),
    )
}

/// Installs a command of cargo from crates.io unless it is there; returns whether it is there.
pub(crate) fn tool(name: &str, version: &str) -> bool {
    let is_there = || Command::new(name).arg("--version").output().is_ok();
    if is_there() {
        return true;
    }
    eprintln!("── installing {name} {version}");
    let status = Command::new(env!("CARGO"))
        .args(["install", "--locked", "--version", version, name])
        .status();
    if status.is_ok_and(|status| status.success()) && is_there() {
        return true;
    }
    eprintln!(
        "── {name} could not be installed: it needs a network, and the folder of cargo's programs in PATH"
    );
    false
}

/// Installs a program for some tests unless it is installed; returns whether it is there.
fn ensure(name: &str, tests: &str, names: &str, is_there: impl Fn() -> bool) -> bool {
    if is_there() {
        return true;
    }
    eprintln!("── installing {name} for the {tests}");
    if packages(names) && is_there() {
        return true;
    }
    eprintln!("── {name} could not be installed: the {tests} cannot run");
    false
}

fn any_exists(paths: &[&str]) -> bool {
    paths.iter().any(|path| Path::new(path).exists())
}

/// Installs packages of a Debian; returns whether that went well.
fn packages(names: &str) -> bool {
    let install = format!(
        "apt-get update -qq && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq \
         --no-install-recommends {names} >/dev/null"
    );
    let done = Command::new("sh").args(["-c", &install]).status();
    done.is_ok_and(|status| status.success())
}
