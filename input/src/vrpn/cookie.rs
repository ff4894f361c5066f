//! The cookie: the 24 bytes that both sides of a connection send first.

/// A cookie's length in bytes.
pub const COOKIE_LENGTH: usize = 24;

/// The version that we speak, as the cookie's first 16 bytes.
const MAGIC: &[u8; 16] = b"vrpn: ver. 07.38";

/// How much of the version must agree: all up to the last dot.
const MAJOR: usize = 14;

/// Our cookie: the version, two blanks, the digit 0 for "log nothing for me", and zeros.
pub const COOKIE: [u8; COOKIE_LENGTH] = *b"vrpn: ver. 07.38  0\0\0\0\0\0";

/// What came in place of a cookie.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CookieError {
    /// It is none of VRPN's.
    #[error("it greets with {said:?}, which no VRPN program does")]
    NotVrpn {
        /// What came, made readable.
        said: String,
    },
    /// It is that of another major version.
    #[error("it speaks {said:?} where version 07 is spoken here")]
    OtherVersion {
        /// The version that came, made readable.
        said: String,
    },
}

/// Checks the other side's cookie. Versions may differ behind the last dot.
///
/// # Errors
/// Where it is no cookie, or that of another major version.
pub fn check_cookie(cookie: &[u8; COOKIE_LENGTH]) -> Result<(), CookieError> {
    if cookie[..MAJOR] == MAGIC[..MAJOR] {
        return Ok(());
    }
    let end = cookie.iter().position(|&b| b == 0).unwrap_or(cookie.len());
    let said = String::from_utf8_lossy(&cookie[..end]).trim().to_owned();
    Err(if cookie.starts_with(b"vrpn: ver. ") {
        CookieError::OtherVersion { said }
    } else {
        CookieError::NotVrpn { said }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cookie_is_as_the_real_program_sends_it() {
        assert_eq!(&COOKIE[..16], b"vrpn: ver. 07.38");
        assert_eq!(COOKIE[16..], [b' ', b' ', b'0', 0, 0, 0, 0, 0]);
        assert!(MAGIC[..MAJOR].ends_with(b"07."));
    }

    #[test]
    fn minor_versions_may_differ_and_major_ones_may_not() {
        let cookie = |text: &[u8]| {
            let mut cookie = [0; COOKIE_LENGTH];
            cookie[..text.len()].copy_from_slice(text);
            cookie
        };
        assert_eq!(check_cookie(&COOKIE), Ok(()));
        assert_eq!(check_cookie(&cookie(b"vrpn: ver. 07.36  2")), Ok(()));
        let other = check_cookie(&cookie(b"vrpn: ver. 08.00  0")).unwrap_err();
        assert!(matches!(other, CookieError::OtherVersion { .. }), "{other}");
        let web = check_cookie(&cookie(b"HTTP/1.1 400 Bad Request")).unwrap_err();
        assert!(web.to_string().contains("HTTP/1.1 400"), "{web}");
        assert!(check_cookie(&[0; COOKIE_LENGTH]).is_err());
        assert!(check_cookie(&[0xff; COOKIE_LENGTH]).is_err());
    }
}
