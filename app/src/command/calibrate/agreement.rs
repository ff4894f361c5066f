//! Fits through touched marks, shown and tried again until whoever touched them agrees.

use super::dialogue::{Answer, Dialogue, quit};
use super::station::Still;
use super::touching::Touched;
use anyhow::Result;
use sandtable_config::Mark;

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
/// touches is called `noun`; `again` has its mark touched anew. What the fit needs cannot be left
/// out.
pub(super) fn agree<'m, F>(
    dialogue: &Dialogue,
    noun: &str,
    mut touched: Vec<Touched<'m>>,
    again: impl Fn(&'m Mark) -> Result<Option<Still>>,
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
        let prompt = format!(
            "{take}a {noun}'s number leaves that {noun} out, t and its number has it touched \
             again; q ends without"
        );
        found = loop {
            let words = match (dialogue.ask(&prompt)?, &offer) {
                (Answer::Enter, Offer::Enter(_)) => return Ok(found),
                (Answer::Words(words), Offer::Discouraged) if words == "w" => return Ok(found),
                (Answer::Quit, _) => return Err(quit()),
                (Answer::Enter, _) => {
                    dialogue.remark("Enter writes nothing here");
                    continue;
                }
                (Answer::Words(words), _) => words,
            };
            let (touch_again, number) = match words.strip_prefix('t') {
                Some(number) => (true, number.trim()),
                None => (false, words.as_str()),
            };
            let number = number.parse::<usize>().ok();
            let Some(index) = number
                .filter(|n| (1..=touched.len()).contains(n))
                .map(|n| n - 1)
            else {
                dialogue.remark(format_args!(
                    "{words:?} is no {noun}: say 1 to {}, or t1 to t{0}",
                    touched.len()
                ));
                continue;
            };
            let mut changed = touched.clone();
            let name = &touched[index].mark.name;
            let done = if touch_again {
                let Some(still) = again(touched[index].mark)? else {
                    continue;
                };
                changed[index].still = still;
                format!("\"{name}\" is touched again")
            } else {
                changed.remove(index);
                format!("\"{name}\" is left out")
            };
            match fit(&changed) {
                Ok(anew) => {
                    dialogue.remark(done);
                    touched = changed;
                    break anew;
                }
                Err(problem) => {
                    dialogue.remark(format_args!("\"{name}\" stays: otherwise, {problem:#}"));
                }
            }
        };
    }
}
