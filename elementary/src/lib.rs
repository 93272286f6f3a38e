//! Sines, exponentials and their kin that are the same to the last bit on every platform.
//!
//! What a C library returns differs in the last bit from that of another, of another version and, where it chooses by
//! the processor, from itself; a search then may go another way. A program with this crate in it takes them from
//! [`libm`], whoever calls them: these definitions stand before the C library's. `use elementary as _` puts it in.
// To name a function as C does is the one thing here that the compiler cannot check.
#![allow(unsafe_code)]

macro_rules! the_same_everywhere {
    ($($name:ident($($x:ident),+) -> $real:ty;)+) => {$(
        #[unsafe(no_mangle)]
        extern "C" fn $name($($x: $real),+) -> $real {
            libm::$name($($x),+)
        }
    )+};
}

the_same_everywhere! {
    acos(x) -> f64;
    asin(x) -> f64;
    atan(x) -> f64;
    atan2(y, x) -> f64;
    atan2f(y, x) -> f32;
    cos(x) -> f64;
    exp(x) -> f64;
    hypot(x, y) -> f64;
    hypotf(x, y) -> f32;
    log(x) -> f64;
    log10(x) -> f64;
    log2(x) -> f64;
    pow(x, y) -> f64;
    sin(x) -> f64;
    tan(x) -> f64;
}

/// Both at once, as compilers for glibc ask for them.
#[unsafe(no_mangle)]
extern "C" fn sincos(x: f64, sin: &mut f64, cos: &mut f64) {
    (*sin, *cos) = libm::sincos(x);
}
