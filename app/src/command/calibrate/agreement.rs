//! Fits through touched marks, shown and tried again until whoever touched them agrees.

use super::dialogue::{Answer, Dialogue, quit};
use super::touching::Touched;
use anyhow::Result;

/// What may be done with a fit that was shown.
pub(super) enum Offer {
    /// Enter takes it, which does what this says.
    Enter(String),
    /// It is better not taken; `w` takes it all the same.
    Discouraged,
    /// There is nothing to take.
    Nothing,
}

/// Fits, shows what came out, and leaves out what the user says until it is agreed on. One of the
/// touches is called `noun`. What the fit needs cannot be left out.
pub(super) fn agree<'m, F>(
    dialogue: &Dialogue,
    noun: &str,
    mut touched: Vec<Touched<'m>>,
    fit: impl Fn(&[Touched<'m>]) -> Result<F>,
    show: impl Fn(&[Touched<'m>], &F) -> Offer,
) -> Result<F> {
    let mut found = fit(&touched)?;
    loop {
        let offer = show(&touched, &found);
        let take = match &offer {
            Offer::Enter(what) => format!("{what}; "),
            Offer::Discouraged => "w writes it all the same; ".to_owned(),
            Offer::Nothing => String::new(),
        };
        let prompt = format!("{take}a {noun}'s number leaves that {noun} out; q ends without");
        found = loop {
            let words = match (dialogue.ask(&prompt)?, &offer) {
                (Answer::Enter, Offer::Enter(_)) => return Ok(found),
                (Answer::Words(words), Offer::Discouraged) if words == "w" => return Ok(found),
                (Answer::Quit, _) => return Err(quit()),
                (Answer::Enter, _) => {
                    eprintln!("Enter writes nothing here");
                    continue;
                }
                (Answer::Words(words), _) => words,
            };
            match words.parse::<usize>() {
                Ok(number) if (1..=touched.len()).contains(&number) => {
                    let out = touched.remove(number - 1);
                    match fit(&touched) {
                        Ok(without) => {
                            eprintln!("\"{}\" is left out", out.mark.name);
                            break without;
                        }
                        Err(problem) => {
                            eprintln!("\"{}\" stays: without it, {problem:#}", out.mark.name);
                            touched.insert(number - 1, out);
                        }
                    }
                }
                _ => eprintln!("{words:?} is no {noun}: say 1 to {}", touched.len()),
            }
        };
    }
}
