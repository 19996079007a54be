/PROG  CELL_LINE
/ATTR
OWNER		= MNEDITOR;
COMMENT		= "Cell server";
PROG_SIZE	= 0;
LINE_COUNT	= 8;
PROTECT		= READ_WRITE;
STACK_SIZE	= 0;
TASK_PRIORITY	= 50;
TIME_SLICE	= 0;
BUSY_LAMP_OFF	= 0;
ABORT_REQUEST	= 0;
PAUSE_REQUEST	= 0;
DEFAULT_GROUP	= 1,*,*,*,*;
CONTROL_CODE	= 00000000 00000000;
/MN
   1:  !Moves once for each time that ;
   2:  !CELL_SERVER sets R[5:go] ;
   3:  IF R[5:go]<>1,JMP LBL[1] ;
   4:  R[5:go]=0    ;
   5:L PR[1:target] R[1:speed]mm/sec FINE    ;
   6:  R[2:arrived]=1    ;
   7:  LBL[1] ;
   8:  END ;
/POS
/END
