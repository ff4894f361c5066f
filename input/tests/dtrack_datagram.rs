//! DTrack's datagrams: the manual's example, Flysticks, and lines that are not what they promise.

use glam::{DMat3, DVec3};
use proptest::prelude::*;
use sandtable_input::dtrack::Datagram;

/// The manual's body.
const EXAMPLE: &str = "6d 1 [0 1.000][326.848 -187.216 109.503 -160.4704 -3.6963 -7.0913]\
    [-0.940508 -0.339238 -0.019025 0.333599 -0.932599 0.137735 -0.064467 0.123194 0.990286]";

fn read(text: &str) -> Datagram {
    let mut datagram = Datagram::default();
    datagram.read(text.as_bytes());
    datagram
}

#[test]
fn the_manuals_example_is_read_column_by_column() {
    let datagram = read(&format!(
        "fr 21753\r\nts 39596.024831\r\n6dcal 3\r\n{EXAMPLE}\r\n"
    ));
    assert_eq!(datagram.frame, Some(21_753));
    assert_eq!(datagram.time_of_day, Some(39_596.024_831));
    assert_eq!(datagram.calibrated, Some(3));
    assert_eq!((datagram.malformed, datagram.body_lines), (0, 1));
    let [body] = datagram.bodies[..] else {
        panic!("{:?}", datagram.bodies);
    };
    assert_eq!(body.id, 0);
    let place = DVec3::new(0.326_848, -0.187_216, 0.109_503);
    assert!((body.position - place).length() < 1e-12);
    assert_eq!(
        body.rotation.x_axis,
        DVec3::new(-0.940_508, -0.339_238, -0.019_025)
    );
    assert_eq!(
        body.rotation.z_axis,
        DVec3::new(-0.064_467, 0.123_194, 0.990_286)
    );
    // Its angles say the same: about x by the third, then y by the second, then z by the first.
    let [z, y, x] = [-160.4704f64, -3.6963, -7.0913].map(f64::to_radians);
    let turns = DMat3::from_rotation_x(x) * DMat3::from_rotation_y(y) * DMat3::from_rotation_z(z);
    let off = (turns - body.rotation).to_cols_array();
    assert!(off.iter().all(|o| o.abs() < 1e-5), "{off:?}");
}

#[test]
fn a_body_that_is_not_seen_is_left_out() {
    let none = read("fr 1\n6dcal 2\n6d 0 \n");
    assert_eq!(
        (none.bodies.len(), none.malformed, none.body_lines),
        (0, 0, 1)
    );
    let unit = "[1 0 0 0 1 0 0 0 1]";
    let two = read(&format!(
        "6d 2 [1 1.0][0 0 0 0 0 0]{unit} [4 -1.000][0 0 0 0 0 0][0 0 0 0 0 0 0 0 0]"
    ));
    assert_eq!(
        two.bodies.iter().map(|body| body.id).collect::<Vec<_>>(),
        [1]
    );
}

#[test]
fn a_flystick_tells_its_controls_even_unseen() {
    let unit = "[1 0 0 0 1 0 0 0 1]";
    let zero = "[0 0 0 0 0 0 0 0 0]";
    let datagram = read(&format!(
        "6df2 3 3 [0 1.000 6 2][1000 2000 -500]{unit}[9 -0.50 1.00] \
         [1 -1.000 3 0][0 0 0]{zero}[5] [2 -1.000 34 1][0 0 0]{zero}[-2147483648 7 0.25]"
    ));
    assert_eq!(datagram.malformed, 0);
    let [a, b, c] = &datagram.flysticks[..] else {
        panic!("{datagram:?}");
    };
    assert_eq!(
        a.body.map(|body| body.position),
        Some(DVec3::new(1.0, 2.0, -0.5))
    );
    assert_eq!((a.controls.pressed, a.controls.count), (0b1001, 2));
    assert_eq!(a.controls.values[..3], [-0.5, 1.0, 0.0]);
    assert_eq!(
        (b.id, b.body, b.controls.pressed, b.controls.count),
        (1, None, 0b101, 0)
    );
    // 34 buttons take two words, the second of which has two: a bit beyond is none.
    assert_eq!(c.controls.pressed, 1 << 31 | 3 << 32);
    let none = read(&format!("6df2 1 1 [0 -1.0 0 0][0 0 0]{zero}[]"));
    assert_eq!((none.flysticks.len(), none.malformed), (1, 0));
    assert_eq!(none.flysticks[0].controls.pressed, 0);
}

#[test]
fn other_lines_are_passed_over() {
    let datagram = read(
        "fr 7\n3d 1 [79 1.000][210.730 -90.669 -108.554]\n6di 1 [0 3 0.1][1 2 3][1 0 0]\n\
         6dmt 0\n6df 1 [0 1.0 4][0 0 0][1]\ngl 0\nsomething of 2031\n\n",
    );
    assert_eq!((datagram.frame, datagram.malformed), (Some(7), 0));
    assert_eq!((datagram.bodies.len(), datagram.body_lines), (0, 0));
}

#[test]
fn a_malformed_line_takes_no_other_with_it() {
    let unit = "[1 0 0 0 1 0 0 0 1]";
    let good = format!("6d 1 [0 1.0][0 0 0 0 0 0]{unit}");
    for bad in [
        "6d",
        "6d x",
        "6d -1",
        "6d 2 [0 1.0][0 0 0 0 0 0][1 0 0 0 1 0 0 0 1]",
        "6d 0 [0 1.0][0 0 0 0 0 0][1 0 0 0 1 0 0 0 1]",
        "6d 4294967295",
        "6d 1 [0][0 0 0 0 0 0][1 0 0 0 1 0 0 0 1]",
        "6d 1 [0.5 1.0][0 0 0 0 0 0][1 0 0 0 1 0 0 0 1]",
        "6d 1 [0 1.0][0 0 0 0 0][1 0 0 0 1 0 0 0 1]",
        "6d 1 [0 1.0][0 0 0 0 0 0 0][1 0 0 0 1 0 0 0 1]",
        "6d 1 [0 1.0][nan 0 0 0 0 0][1 0 0 0 1 0 0 0 1]",
        "6d 1 [0 1.0][0 0 0 0 0 0][1 0 0 0 1 0 0 0 1",
        "6d 1 [0 1.0][0 0 0 0 0 0][1 0 0 0 1 0 0 0 inf]",
        "6d 1 [0 1.0][0 0 0 0 0 0][1 0 0 0 1 0 0 0 1] more",
        "6df2 1",
        "6df2 1 1 [0 1.0 65 0][0 0 0][1 0 0 0 1 0 0 0 1][0 0 0]",
        "6df2 1 1 [0 1.0 4294967295 0][0 0 0][1 0 0 0 1 0 0 0 1][]",
        "6df2 1 1 [0 1.0 0 33][0 0 0][1 0 0 0 1 0 0 0 1][]",
        "6df2 1 1 [0 1.0 3 1][0 0 0][1 0 0 0 1 0 0 0 1][1]",
        "6df2 1 1 [0 1.0 3 0][0 0 0][1 0 0 0 1 0 0 0 1][4294967296]",
        "fr",
        "fr -1",
        "fr 4294967296",
        "ts noon",
        "6dcal 2 3",
    ] {
        // One body of its own before what is wrong does not come through.
        let datagram = read(&format!("{bad}\r\n{good}\r\nfr 3\r\n"));
        assert_eq!(datagram.malformed, 1, "{bad}");
        assert_eq!(
            (datagram.bodies.len(), datagram.frame),
            (1, Some(3)),
            "{bad}"
        );
        assert_eq!(datagram.flysticks.len(), 0, "{bad}");
    }
}

/// Bodies as a controller writes them.
fn written(bodies: &[(u32, [f64; 3], [f64; 9])]) -> String {
    let mut text = format!("6d {}", bodies.len());
    for (id, [x, y, z], b) in bodies {
        let b = b.map(|b| b.to_string()).join(" ");
        text += &format!(" [{id} 1.000][{x} {y} {z} 0.0 0.0 0.0][{b}]");
    }
    text
}

proptest! {
    #[test]
    fn what_is_written_is_read(
        frame: u32,
        bodies in prop::collection::vec(
            (any::<u32>(), [-1e5..1e5f64, -1e5..1e5, -1e5..1e5], [(); 9].map(|()| -1.0..1.0f64)),
            0..20,
        ),
    ) {
        let datagram = read(&format!("fr {frame}\r\n{}\r\n", written(&bodies)));
        prop_assert_eq!((datagram.frame, datagram.malformed), (Some(frame), 0));
        let back: Vec<_> = datagram
            .bodies
            .iter()
            .map(|body| (body.id, body.position, body.rotation.to_cols_array()))
            .collect();
        let sent: Vec<_> = bodies
            .iter()
            .map(|(id, place, b)| (*id, DVec3::from_array(*place) * 1e-3, *b))
            .collect();
        prop_assert_eq!(back, sent);
    }

    #[test]
    fn no_bytes_make_it_panic_or_grow(bytes: Vec<u8>, at: usize, byte: u8) {
        let mut datagram = Datagram::default();
        datagram.read(&bytes);
        let mut altered = format!("fr 1\n{EXAMPLE}\n6df2 1 1 [0 1.0 3 1][0 0 0][1 0 0 0 1 0 0 0 1][5 0.5]")
            .into_bytes();
        let at = at % altered.len();
        altered[at] = byte;
        datagram.read(&altered);
        prop_assert!(datagram.bodies.len() <= 1 && datagram.flysticks.len() <= 1);
        prop_assert!(datagram.bodies.capacity() + datagram.flysticks.capacity() <= 16);
    }
}
