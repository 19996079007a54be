//! Answers of humans: one decision for each question, by name, with a reason.

mod going_on;
mod job;
mod load;
mod session;
mod swap;

use uuid::Uuid;

use crate::commands_in::allowed;
use crate::input::{Principal, Refusal, Reply};
use crate::intervention::{Answer, Decided, Detail};
use crate::words;
use crate::work::Work;

impl Work<'_> {
    pub(crate) fn respond(
        &mut self,
        id: Uuid,
        answer: Answer,
        detail: Detail,
        principal: &Principal,
        reason: &str,
    ) -> Result<Reply, Refusal> {
        let name = format!("answer {}", words::word(&answer));
        allowed(&name, principal, reason)?;
        let Some(found) = self.cell.book.interventions.get(&id).cloned() else {
            return Err(Refusal::Unknown {
                what: "intervention",
                id: id.to_string(),
            });
        };
        let decided = Decided {
            answer,
            detail,
            principal: principal.name.clone(),
            reason: reason.to_owned(),
        };
        if found.decided.as_ref() == Some(&decided) {
            return Ok(Reply::Unchanged);
        }
        let conflict = |text: String| Refusal::Conflict {
            command: name.clone(),
            text,
        };
        if !found.is_open() {
            return Err(conflict("the question was decided or withdrawn".into()));
        }
        if !found.question.answers.contains(&answer) {
            let allowed = found.question.answers.iter().map(words::word);
            let allowed = allowed.collect::<Vec<_>>().join(", ");
            return Err(conflict(format!("allowed are {allowed}")));
        }
        if principal.role < answer.needs() {
            return Err(Refusal::Forbidden {
                command: name,
                needed: answer.needs(),
            });
        }
        let question = found.question.clone();
        if question.session.is_some() {
            return self.answer_session(&question, decided);
        }
        if let (None, Some(load)) = (question.job, &question.load) {
            return self.answer_load(&question, load, decided, principal, reason);
        }
        let Some(job) = question.job.and_then(|j| self.job(j)) else {
            return Err(conflict("its job is not known any more".into()));
        };
        let reply = self.answer_job(&job, &question, decided, principal)?;
        self.wait_anew(job.id);
        Ok(reply)
    }
}
