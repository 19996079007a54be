//! The question where a load is.

use crate::fact::Fact;
use crate::input::{Principal, Refusal, Reply};
use crate::intervention::{Decided, Detail, Question};
use crate::words;
use crate::work::Work;

impl Work<'_> {
    /// The question where a load is that no job has.
    pub(super) fn answer_load(
        &mut self,
        question: &Question,
        asked: &str,
        decided: Decided,
        principal: &Principal,
        reason: &str,
    ) -> Result<Reply, Refusal> {
        let Detail::Custody {
            load,
            confirm,
            location,
        } = &decided.detail
        else {
            return Err(Refusal::Invalid {
                item: "detail".into(),
                problem: format!("{} needs to know where", words::word(&decided.answer)),
            });
        };
        if load != asked {
            return Err(Refusal::Conflict {
                command: format!("answer {}", words::word(&decided.answer)),
                text: format!("the question is about load {asked}"),
            });
        }
        self.set_custody(load, location, confirm, principal, reason)?;
        self.answers_instead_of_withdrawing(question);
        self.emit(Fact::Answered {
            intervention: question.id,
            decided,
        });
        Ok(Reply::Done)
    }

    /// The statement itself withdrew the question; here it is an answer.
    pub(super) fn answers_instead_of_withdrawing(&mut self, question: &Question) {
        self.facts.retain(
            |f| !matches!(f, Fact::Withdrawn { intervention, .. } if *intervention == question.id),
        );
        if let Some(open) = self.cell.book.interventions.get_mut(&question.id) {
            std::sync::Arc::make_mut(open).withdrawn = None;
        }
    }
}
