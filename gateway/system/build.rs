//! Compiles the executor of the simulation, `ssp/executor.c`, into this crate.

use std::env;
use std::path::{Path, PathBuf};

const VARIABLE: &str = "FLEXHEX_FMI_HEADERS";

fn main() {
    let ssp = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../ssp");
    println!("cargo:rerun-if-env-changed={VARIABLE}");
    for file in ["executor.c", "executor.h"] {
        println!("cargo:rerun-if-changed={}", ssp.join(file).display());
    }
    cc::Build::new()
        .file(ssp.join("executor.c"))
        .include(headers())
        .std("c99")
        .opt_level(2)
        .flag("-ffp-contract=off")
        .flags(["-Wall", "-Wextra", "-Wconversion", "-Werror"])
        .compile("flexhex_executor");
    println!("cargo:rustc-link-lib=dl");
}

/// Folder of fmi2FunctionTypes.h and fmi2TypesPlatform.h of the FMI 2.0 standard.
fn headers() -> PathBuf {
    let hint = "`make gateway` sets it; by hand: FLEXHEX_FMI_HEADERS=$(python -c \
                'import fmpy, os; print(os.path.dirname(fmpy.__file__))')/c-code";
    let Some(folder) = env::var_os(VARIABLE).map(PathBuf::from) else {
        panic!("{VARIABLE} is not set: the folder of the FMI 2.0 headers. {hint}");
    };
    if !folder.join("fmi2FunctionTypes.h").is_file() {
        let folder = folder.display();
        panic!("{VARIABLE} = {folder}: holds no fmi2FunctionTypes.h. {hint}");
    }
    folder
}
