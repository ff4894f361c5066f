//! `sandtable serve-vrpn`: a simulated Flock for another program, which is played here by hand.

use crate::program::{Folder, Running, sandtable};
use crate::simulate::Simulated;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::Stdio;
use std::time::Duration;

/// A message's length, its six header words and padding counted, and its payload's length.
fn lengths(header: &[u8; 24]) -> (usize, usize) {
    let length = u32::from_be_bytes([header[0], header[1], header[2], header[3]]) as usize;
    let payload = length - 24;
    (payload.next_multiple_of(8), payload)
}

#[test]
fn another_program_hears_the_birds() {
    let folder = Folder::new();
    let flock = Simulated::start(
        &folder,
        "flock",
        "--hold 12,3,-5,0,0,0 --hold 8,-2,-6,0,0,0",
    );
    let mut command = sandtable(folder.path());
    let device = format!("flock={}", flock.path.display());
    command.args(["serve-vrpn", "--listen", "127.0.0.1:0", "--device", &device]);
    command.stdout(Stdio::piped()).stderr(Stdio::null());
    let mut server = Running(command.spawn().expect("the program starts"));
    let out = server.0.stdout.take().expect("it is piped");
    let mut address = String::new();
    BufReader::new(out)
        .read_line(&mut address)
        .expect("its address");

    let mut guest = TcpStream::connect(address.trim()).expect("it listens");
    guest
        .set_read_timeout(Some(Duration::from_secs(20)))
        .expect("a time-out");
    let mut cookie = [0; 24];
    cookie[..16].copy_from_slice(b"vrpn: ver. 07.38");
    cookie[16..19].copy_from_slice(b"  0");
    guest.write_all(&cookie).expect("it reads");
    guest.read_exact(&mut cookie).expect("its cookie");
    assert!(cookie.starts_with(b"vrpn: ver. 07."));

    // Names by numbers, and then poses: sensor, filler, position, quaternion.
    let (mut senders, mut types) = (Vec::new(), Vec::new());
    let mut heard = [false; 2];
    while heard != [true; 2] {
        let mut header = [0; 24];
        guest.read_exact(&mut header).expect("a message");
        let word = |at: usize| i32::from_be_bytes(header[at..at + 4].try_into().unwrap());
        let (padded, length) = lengths(&header);
        let mut payload = vec![0; padded];
        guest.read_exact(&mut payload).expect("its payload");
        let (sender, kind) = (word(12), word(16));
        let name = || {
            let name = payload[4..length]
                .split(|&byte| byte == 0)
                .next()
                .unwrap_or(&[]);
            String::from_utf8_lossy(name).into_owned()
        };
        match kind {
            -1 => senders.push((sender, name())),
            -2 => types.push((sender, name())),
            _ if types.contains(&(kind, "vrpn_Tracker Pos_Quat".into())) => {
                assert!(senders.contains(&(sender, "flock".into())), "{senders:?}");
                let sensor = i32::from_be_bytes(payload[..4].try_into().unwrap());
                let number =
                    |at: usize| f64::from_be_bytes(payload[at..at + 8].try_into().unwrap());
                // In the workbench's frame the transmitter's x points away and its z down.
                let inches = [[12.0, 3.0, -5.0], [8.0, -2.0, -6.0]][sensor as usize];
                let [x, y, z] = inches.map(|inch: f64| inch * 0.0254);
                let expected = [y, x, -0.3 - z];
                for (k, expected) in expected.iter().enumerate() {
                    let found = number(8 + 8 * k);
                    assert!(
                        (found - expected).abs() < 5e-4,
                        "{sensor}: {found}, {expected}"
                    );
                }
                heard[sensor as usize] = true;
            }
            _ => {}
        }
    }
    server.signal("INT");
    assert_eq!(server.end().code(), Some(0));
}

#[test]
fn what_cannot_be_served_is_refused() {
    let folder = Folder::new();
    folder
        .run("serve-vrpn --rig desktop")
        .failed(1, &["no devices"]);
    folder
        .run("serve-vrpn --listen here")
        .failed(2, &["--listen"]);
    let other = std::net::TcpListener::bind("127.0.0.1:0").expect("a port");
    let taken = other.local_addr().expect("it has one");
    let refused = folder.run(&format!("serve-vrpn --listen {taken}"));
    refused.failed(1, &["cannot listen", &taken.to_string(), "name a port"]);
}
