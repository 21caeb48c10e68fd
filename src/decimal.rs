//! Decimal numbers in texts.

/// The number nearest to what `text` says; none where that is no number.
#[cfg(not(all(target_arch = "wasm32", feature = "web")))]
pub(crate) fn parse(text: &str) -> Option<f64> {
    text.parse().ok()
}

/// The same by the browser, which rounds as well: the tables that it takes need not be downloaded.
#[cfg(all(target_arch = "wasm32", feature = "web"))]
pub(crate) fn parse(text: &str) -> Option<f64> {
    match text {
        // As Python writes them.
        "inf" => Some(f64::INFINITY),
        "-inf" => Some(f64::NEG_INFINITY),
        "nan" => Some(f64::NAN),
        // JavaScript reads more than decimal numbers, nothing as zero, and what is misspelt as NaN.
        _ if text.is_empty() || !text.bytes().all(|byte| b"0123456789+-.eE".contains(&byte)) => None,
        _ => Some(wasm_bindgen::JsValue::from_str(text).unchecked_into_f64()).filter(|number| !number.is_nan()),
    }
}
